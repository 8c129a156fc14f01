/* The life of an FMU, from instantiation to the end, for a compiler that watches memory. The functions have a prefix, as
 * a tool gives them that links an FMU's sources. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mw_fmi2.h"
#include "mw_model.h"

fmi2Component my_fmi2Instantiate(fmi2String, fmi2Type, fmi2String, fmi2String, const fmi2CallbackFunctions *, fmi2Boolean,
                                 fmi2Boolean);
void my_fmi2FreeInstance(fmi2Component);
fmi2Status my_fmi2SetupExperiment(fmi2Component, fmi2Boolean, fmi2Real, fmi2Real, fmi2Boolean, fmi2Real);
fmi2Status my_fmi2EnterInitializationMode(fmi2Component);
fmi2Status my_fmi2ExitInitializationMode(fmi2Component);
fmi2Status my_fmi2DoStep(fmi2Component, fmi2Real, fmi2Real, fmi2Boolean);
fmi2Status my_fmi2GetReal(fmi2Component, const fmi2ValueReference[], size_t, fmi2Real[]);
fmi2Status my_fmi2Terminate(fmi2Component);
fmi2Status my_fmi2Reset(fmi2Component);

#define START 7.25
#define STEPS 40

static void need(int condition, const char *what)
{
    if (!condition) {
        printf("not so: %s\n", what);
        exit(1);
    }
}

static void run(fmi2Component of, double from_s, fmi2Real values[MW_REALS])
{
    fmi2ValueReference references[MW_REALS];
    unsigned index;
    for (index = 0; index < MW_REALS; index++)
        references[index] = MW_FIRST_REAL + index;
    for (index = 0; index < STEPS; index++)
        need(my_fmi2DoStep(of, from_s + 0.05 * index, 0.05, 0) <= fmi2Warning, "a step");
    need(my_fmi2GetReal(of, references, MW_REALS, values) == fmi2OK, "values");
}

static void initialize(fmi2Component of)
{
    need(my_fmi2SetupExperiment(of, 0, 0.0, START, 0, 0.0) == fmi2OK, "set up");
    need(my_fmi2EnterInitializationMode(of) == fmi2OK, "initialization");
    need(my_fmi2ExitInitializationMode(of) == fmi2OK, "its end");
}

int main(void)
{
    const fmi2CallbackFunctions none = {0, 0, 0, 0, 0};
    fmi2Component of = my_fmi2Instantiate("life", fmi2CoSimulation, MW_GUID, "", &none, 0, 0);
    fmi2Real first[MW_REALS], again[MW_REALS];
    need(of != NULL, "an instance");
    need(my_fmi2Instantiate("life", fmi2CoSimulation, "{another}", "", &none, 0, 0) == NULL, "another GUID is refused");
    need(my_fmi2Instantiate(NULL, fmi2ModelExchange, MW_GUID, "", NULL, 0, 0) == NULL, "model exchange is refused");
    initialize(of);
    run(of, START, first);
    need(my_fmi2Terminate(of) == fmi2OK && my_fmi2DoStep(of, 0.0, 0.05, 0) == fmi2Error, "no step after the end");
    need(my_fmi2Reset(of) == fmi2OK, "reset");
    initialize(of);
    run(of, START, again);
    need(memcmp(first, again, sizeof first) == 0, "the same values");
    my_fmi2FreeInstance(of);
    my_fmi2FreeInstance(NULL);
    printf("the same to the bit\n");
    return 0;
}
