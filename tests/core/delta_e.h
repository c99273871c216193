/* CIEDE2000, the colour difference that tests of colour are stated in. */
#ifndef DELTA_E_H
#define DELTA_E_H

void lab_of_xyz(const double xyz[3], const double white[3], double lab[3]);
double delta_e_2000(const double lab1[3], const double lab2[3]);

#endif
