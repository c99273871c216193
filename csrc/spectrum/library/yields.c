/* Fluorescence quantum yields of the library's dyes, each with who measured it in that solvent. Dyes without such a source are left out. */
#include <string.h>

#include "spectrum/library/library.h"

#define BERLMAN "I. B. Berlman, Handbook of Fluorescence Spectra of Aromatic Molecules (1971)"
#define REYNOLDS "G. A. Reynolds, K. H. Drexhage, Opt. Commun. 13, 222 (1975)"
#define SEYBOLD "P. G. Seybold, M. Gouterman, J. Callis, Photochem. Photobiol. 9, 229 (1969)"
#define SENS "R. Sens, K. H. Drexhage, J. Lumin. 24-25, 709 (1981)"
#define PATTERSON "G. Patterson, R. N. Day, D. Piston, J. Cell Sci. 114, 837 (2001)"
#define PROBES "The Molecular Probes Handbook, 11th ed., table 1.5"
#define ATTO "ATTO-TEC GmbH, product data"

static const struct {
    const char *dye;
    double yield;
    const char *source;
} yields[] = {
    {"alexa-fluor-488", 0.92, PROBES},
    {"alexa-fluor-546", 0.79, PROBES},
    {"alexa-fluor-594", 0.66, PROBES},
    {"atto-425_water", 0.9, ATTO},
    {"atto-488_water", 0.8, ATTO},
    {"atto-532_water", 0.9, ATTO},
    {"atto-565_water", 0.9, ATTO},
    {"atto-590_water", 0.8, ATTO},
    {"atto-610_water", 0.7, ATTO},
    {"atto-655_water", 0.3, ATTO},
    {"coumarin-1_ethanol", 0.73, "J. Olmsted, J. Phys. Chem. 83, 2581 (1979)"},
    {"coumarin-30_acetonitrile", 0.67,
     "G. Jones, W. R. Jackson, C. Choi, W. R. Bergmark, J. Phys. Chem. 89, 294 (1985)"},
    {"coumarin-343_ethanol", 0.63, REYNOLDS},
    {"coumarin-6_ethanol", 0.78, REYNOLDS},
    {"ecfp", 0.4, PATTERSON},
    {"egfp", 0.6, PATTERSON},
    {"eyfp", 0.61, PATTERSON},
    {"fluorescein_ph13", 0.93, "D. Magde, R. Wong, P. G. Seybold, Photochem. Photobiol. 75, 327 (2002)"},
    {"nile-blue_methanol", 0.27, SENS},
    {"nile-red_dioxane", 0.7, "D. L. Sackett, J. Wolff, Anal. Biochem. 167, 228 (1987)"},
    {"perylene_cyclohexane", 0.94, BERLMAN},
    {"popop_cyclohexane", 0.93, BERLMAN},
    {"quinine-sulfate_h2so4", 0.546, "W. H. Melhuish, J. Phys. Chem. 65, 229 (1961)"},
    {"rhodamine-6g_ethanol", 0.95, "R. F. Kubin, A. N. Fletcher, J. Lumin. 27, 455 (1982)"},
    {"rose-bengal_basic-ethanol", 0.11, SEYBOLD},
    {"tetraphenylporphyrin_toluene", 0.11, "P. G. Seybold, M. Gouterman, J. Mol. Spectrosc. 31, 1 (1969)"},
    {"wild-type-gfp", 0.79, "R. Y. Tsien, Annu. Rev. Biochem. 67, 509 (1998)"},
};

bool library_yield(const char *dye, double *yield, const char **source)
{
    for (size_t i = 0; i < sizeof yields / sizeof *yields; i++)
        if (strcmp(yields[i].dye, dye) == 0) {
            *yield = yields[i].yield;
            *source = yields[i].source;
            return true;
        }
    return false;
}
