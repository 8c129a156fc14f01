/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* The endpoint of a finger at the connector. */
#include "mw_wire.h"
#include "mw_finger.h"

#if MW_FINGER

/* A column of the curve over tendon travel, continued with its last slope. */
static double column(const double *values, double travel_m)
{
    const int last = MW_FINGER_POINTS - 1;
    const double *at = mw_finger_travel_m;
    double beyond_m = travel_m - at[last];
    int low = 0, high = last;
    if (beyond_m >= 0.0)
        return values[last] + beyond_m * (values[last] - values[last - 1]) / (at[last] - at[last - 1]);
    if (travel_m <= at[0])
        return values[0];
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (at[middle] <= travel_m)
            low = middle;
        else
            high = middle;
    }
    return (values[low + 1] - values[low]) / (at[low + 1] - at[low]) * (travel_m - at[low]) + values[low];
}

mw_endpoint mw_endpoint_at(double displacement_m)
{
    const double drawn_m = displacement_m - MW_FINGER_SLACK_M + MW_FINGER_START_M;
    const double travel_m = drawn_m > 0.0 ? drawn_m : 0.0;
    const double free_m = column(mw_finger_endpoint_m, travel_m);
    const double soft = column(mw_finger_compliance_m_per_n, travel_m);
    const double reach_m = free_m + 0.0 - MW_FINGER_CLEARANCE_M;
    const double inside_m = reach_m > 0.0 ? reach_m : 0.0;
    mw_endpoint found;
    found.force_n = MW_FINGER_OBJECT_N_PER_M * inside_m / (1.0 + MW_FINGER_OBJECT_N_PER_M * soft);
    found.displacement_m = free_m - soft * found.force_n;
    found.beyond_m = displacement_m + MW_FINGER_START_M - MW_FINGER_SLACK_M - mw_finger_travel_m[MW_FINGER_POINTS - 1];
    return found;
}

#else

typedef int mw_no_finger; /* C has no empty files */

#endif
