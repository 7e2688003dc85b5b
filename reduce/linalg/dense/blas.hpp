// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The routines of BLAS and LAPACK that are used, by their Fortran names; for .cpp files only.
extern "C" {
void dgemm_(const char*, const char*, const int*, const int*, const int*, const double*, const double*,
            const int*, const double*, const int*, const double*, double*, const int*);
void sgemm_(const char*, const char*, const int*, const int*, const int*, const float*, const float*,
            const int*, const float*, const int*, const float*, float*, const int*);
void dtrsm_(const char*, const char*, const char*, const char*, const int*, const int*, const double*,
            const double*, const int*, double*, const int*);
void strsm_(const char*, const char*, const char*, const char*, const int*, const int*, const float*,
            const float*, const int*, float*, const int*);
void dsyevd_(const char*, const char*, const int*, double*, const int*, double*, double*, const int*, int*,
             const int*, int*);
void dsygvd_(const int*, const char*, const char*, const int*, double*, const int*, double*, const int*,
             double*, double*, const int*, int*, const int*, int*);
}
