/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* A flexible finger at the connector, by its curve over tendon travel: musclewire.rigs._mechanism.Tendon.
 *
 * Its force on the connector is in the load's table; here is where its endpoint is, and what an object in the endpoint's
 * way pushes back with. */
#ifndef MW_FINGER_H
#define MW_FINGER_H

#include "mw_finger_numbers.h" /* written by the export: MW_FINGER, the curve, slack, start, object */

typedef struct {
    double displacement_m, force_n; /* of the endpoint, under the object's force */
    double beyond_m;                /* travel of the tendon beyond the curve's end; the curve does not cover it if above 0 */
} mw_endpoint;

/* The endpoint at a displacement of the connector. */
mw_endpoint mw_endpoint_at(double displacement_m);

#endif
