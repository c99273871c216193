/* The spectrum library for those outside: names, and values at any wavelength. */
#include "session/session.h"

const char *stokes_library_name(size_t index)
{
    return library_name(index);
}

bool stokes_library_value(const char *name, double lambda_nm, double *value)
{
    const struct range about = {(float)lambda_nm - 1, (float)lambda_nm + 1};
    struct spectrum *spectrum = spectrum_library(about, name, name, NULL);
    if (!spectrum)
        return false;
    *value = spectrum_eval(spectrum, (float)lambda_nm);
    spectrum_destroy(spectrum);
    return true;
}
