/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* The part of the FMI 2.0 interface that a co-simulation FMU offers: its types, and the functions of mw_fmi2.c.
 *
 * Names, types and orders of arguments are those of the Functional Mock-up Interface standard 2.0 (fmi-standard.org),
 * platform "default". With the standard's own headers in a compiler's path nothing changes: these are not included.
 */
#ifndef MW_FMI2_H
#define MW_FMI2_H

#include <stddef.h>

/* A tool that links an FMU's sources defines FMI2_FUNCTION_PREFIX, and finds the functions by names with that prefix. */
#define MW_JOINED(prefix, name) prefix##name
#define MW_JOIN(prefix, name) MW_JOINED(prefix, name)
#if defined(FMI2_FUNCTION_PREFIX)
#define MW_FMI(name) MW_JOIN(FMI2_FUNCTION_PREFIX, name)
#define MW_EXPORTED
#else
#define MW_FMI(name) name
#if defined(_WIN32)
#define MW_EXPORTED __declspec(dllexport)
#elif defined(__GNUC__)
#define MW_EXPORTED __attribute__((visibility("default")))
#else
#define MW_EXPORTED
#endif
#endif

typedef void *fmi2Component;
typedef void *fmi2ComponentEnvironment;
typedef void *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef char fmi2Byte;
typedef const char *fmi2String;

typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;

typedef struct {
    void (*logger)(fmi2ComponentEnvironment, fmi2String instance, fmi2Status, fmi2String category, fmi2String message,
                   ...);
    void *(*allocateMemory)(size_t count, size_t bytes);
    void (*freeMemory)(void *);
    void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
    fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

#endif
