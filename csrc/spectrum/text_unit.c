/* Finding a unit among the words of a title. */
#include "spectrum/text_unit.h"

#include <stdbool.h>
#include <string.h>
#include <strings.h>

/* Bytes of other alphabets are letters: Å is one of UTF-8's, or of Latin-1's. */
static bool is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (unsigned char)c >= 0x80;
}

struct word {
    const char *start;
    size_t length;
};

static bool is(struct word w, const char *text)
{
    return w.length == strlen(text) && strncasecmp(w.start, text, w.length) == 0;
}

static bool begins(struct word w, const char *text)
{
    return w.length >= strlen(text) && strncasecmp(w.start, text, strlen(text)) == 0;
}

/* Å in UTF-8 (the letter, the sign, A with a ring) and in Latin-1; angstrom, ångström and their plurals by what they share. */
static bool is_angstrom(struct word w)
{
    static const char *const signs[] = {"\xc3\x85", "\xe2\x84\xab", "A\xcc\x8a", "\xc5", "ang", "angs"};
    for (size_t i = 0; i < sizeof signs / sizeof *signs; i++)
        if (is(w, signs[i]))
            return true;
    for (const char *c = w.start; c + 5 <= w.start + w.length; c++)
        if (strncasecmp(c, "ngstr", 5) == 0)
            return true;
    return false;
}

/* (A), [A] in the title of the first column; beyond it A is an absorbance. */
static bool is_bare_angstrom(const char *title, struct word w)
{
    size_t before = (size_t)(w.start - title);
    return is(w, "A") && before > 0 && strchr("([", w.start[-1]) && w.start[1] && strchr(")]", w.start[1]) &&
           strcspn(title, ",;\t") > before;
}

static bool is_wavenumber(const char *title, struct word w)
{
    static const char *const powers[] = {"-1", "^-1", "^(-1)", "\xe2\x81\xbb\xc2\xb9", "\xe2\x88\x92\x31"};
    if (begins(w, "wavenumber"))
        return true;
    for (size_t i = 0; i < sizeof powers / sizeof *powers; i++)
        if (w.length >= 2 && strncasecmp(w.start, "cm", 2) == 0 &&
            strncmp(w.start + 2, powers[i], strlen(powers[i])) == 0)
            return true;
    return is(w, "cm") && w.start > title && w.start[-1] == '/';
}

static enum text_unit unit_of_word(const char *title, struct word w)
{
    if (is(w, "nm") || begins(w, "nanomet"))
        return UNIT_NM;
    if (is_angstrom(w) || is_bare_angstrom(title, w))
        return UNIT_ANGSTROM;
    return is_wavenumber(title, w) || is(w, "THz") || is(w, "PHz") ? UNIT_OTHER : UNIT_UNSAID;
}

enum text_unit text_unit_of(const char *title)
{
    enum text_unit unit = UNIT_UNSAID;
    for (const char *c = title; *c && unit == UNIT_UNSAID;) {
        struct word w = {c, 0};
        while (is_letter(c[w.length]))
            w.length++;
        if (w.length > 0)
            unit = unit_of_word(title, w);
        c += w.length > 0 ? w.length : 1;
    }
    return unit;
}
