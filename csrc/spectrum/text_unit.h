/* The unit of wavelengths, as titles above a table name it. */
#ifndef SPECTRUM_TEXT_UNIT_H
#define SPECTRUM_TEXT_UNIT_H

enum text_unit {
    UNIT_UNSAID,
    UNIT_NM,
    UNIT_ANGSTROM,
    UNIT_OTHER /* wavenumbers or frequencies, whose order is that of no wavelengths */
};

/* The first that a title names: the wavelengths are its first column. µm are not looked for, since their numbers give them away. */
enum text_unit text_unit_of(const char *title);

#endif
