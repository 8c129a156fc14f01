/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* The number type of this library, and the rules that a compiler must follow so that every target gives the same bits.
 *
 * mw_real is float; with -DMW_DOUBLE it is double. Every operation is rounded once, to mw_real: no fused
 * multiply-add (-ffp-contract=off), no wider intermediate results (x87), no -ffast-math. What can be checked
 * here is checked here; pass -ffp-contract=off all the same, and -std=c99 where your project allows it.
 */
#ifndef MW_REAL_H
#define MW_REAL_H

#include <float.h>
#include <stdint.h>

#include "mw_constants.h"

#if defined(__FAST_MATH__)
#error "musclewire: -ffast-math changes results and may drop the checks for NaN; compile these files without it"
#endif
/* 16 widens _Float16 alone (ISO/IEC TS 18661-3), on processors with AVX512-FP16; float and double are as with 0. */
#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0 && FLT_EVAL_METHOD != 16
#error "musclewire: this target computes in wider numbers than it stores (FLT_EVAL_METHOD is neither 0 nor 16); on 32 bit x86 use -msse2 -mfpmath=sse"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off")
#else
#pragma STDC FP_CONTRACT OFF
#endif

#if defined(MW_DOUBLE)
typedef double mw_real;
#define MW_R(number) number
#define MW_LARGEST DBL_MAX
typedef char mw_double_must_have_64_bits[sizeof(double) == 8 ? 1 : -1];
#else
typedef float mw_real;
#define MW_R(number) number##f
#define MW_LARGEST FLT_MAX
typedef char mw_float_must_have_32_bits[sizeof(float) == 4 ? 1 : -1];
#endif

/* Resistance of the wire from two voltages (Lan and Fan 2010, Eq. 1), the only place with this equation; the division
 * comes first, as in musclewire.physics._resistance. */
#define MW_SERIES_RESISTANCE(wire_voltage_v, shunt_voltage_v) \
    ((wire_voltage_v) / (shunt_voltage_v) * MW_SHUNT_RESISTANCE_OHM)

/* Tables stay in program memory on targets that separate it (AVR, with -std=gnu99); on others const is enough. */
#if defined(__FLASH) && !defined(__STRICT_ANSI__)
#define MW_TABLE static const __flash
#define MW_FLASH __flash
#else
#define MW_TABLE static const
#define MW_FLASH
#endif

#endif
