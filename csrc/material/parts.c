/* Parts of elastic lobes over wavelength: by tables in constant time, or by quadrature. What has no table is smooth: colours upsampled
   from RGB, and Fresnel's formulae over tabulated indices. */
#include "material/parts.h"

#define PIECE_NM 50

double part_quadrature(double (*f)(const void *, double x), const void *of, double a, double b)
{
    static const double node[] = {0.06943184420297371, 0.33000947820757187, 0.6699905217924281,
                                  0.9305681557970263};
    static const double weight[] = {0.17392742256872693, 0.32607257743127307, 0.32607257743127307,
                                    0.17392742256872693};
    int pieces = 1 + (int)((b - a) / PIECE_NM);
    double width = (b - a) / pieces, sum = 0;
    for (int i = 0; i < pieces; i++)
        for (int k = 0; k < 4; k++)
            sum += weight[k] * f(of, a + width * (i + node[k]));
    return sum * width;
}

double part_at(const struct lobe *lobe, enum part part, struct range range, float z, float lambda)
{
    if (!(lambda >= range.min && lambda <= range.max))
        return 0;
    if (lobe->kind->part)
        return lobe->kind->part(lobe, part, lambda);
    return part == PART_KEPT ? 1 : lobe->kind->albedo(lobe, z, lambda);
}

struct part_of {
    const struct lobe *lobe;
    enum part part;
    struct range range;
    float z;
    double end;
};

static double value_at(const void *user, double x)
{
    const struct part_of *p = user;
    return part_at(p->lobe, p->part, p->range, p->z, (float)x);
}

static double weighted_at(const void *user, double x)
{
    return (((const struct part_of *)user)->end - x) * value_at(user, x);
}

static bool terms_of(const struct lobe *lobe, enum part part, struct part_terms *terms)
{
    return lobe->kind->terms && lobe->kind->terms(lobe, part, terms);
}

double part_integral(const struct lobe *lobe, enum part part, struct range range, float z, double a, double b)
{
    struct part_terms terms;
    a = fmax(a, range.min);
    b = fmin(b, range.max);
    if (!(b > a))
        return 0;
    if (!terms_of(lobe, part, &terms))
        return part_quadrature(value_at, &(struct part_of){lobe, part, range, z, b}, a, b);
    double sum = terms.constant * (b - a);
    for (int i = 0; i < terms.count; i++)
        sum += terms.term[i].factor * (spectrum_integral_to(terms.term[i].spectrum, (float)b) -
                                       spectrum_integral_to(terms.term[i].spectrum, (float)a));
    return sum;
}

/* ∫ (b − x) f(x) dx. */
double part_second(const struct lobe *lobe, enum part part, struct range range, float z, double a, double b)
{
    struct part_terms terms;
    double low = fmax(a, range.min), high = fmin(b, range.max);
    if (!(high > low))
        return 0;
    if (!terms_of(lobe, part, &terms))
        return part_quadrature(weighted_at, &(struct part_of){lobe, part, range, z, b}, low, high);
    double sum = terms.constant * (high - low) * (b - 0.5 * (low + high));
    for (int i = 0; i < terms.count; i++) {
        const struct spectrum *s = terms.term[i].spectrum;
        double before = spectrum_integral_to(s, (float)low), after = spectrum_integral_to(s, (float)high);
        sum += terms.term[i].factor *
               (spectrum_second_integral_to(s, (float)high) - spectrum_second_integral_to(s, (float)low) -
                before * (high - low) + (after - before) * (b - high));
    }
    return sum;
}
