/* One function at many samples: every result of function(clock, state) at every clock and state. */

#include <math.h>
#include <string.h>

#include "callee.h"

/* collected[r] is (samples, widths[r]), a row a sample */
void amble_along(const Callee *callee, int samples, const double *clocks, const double *states,
                 double *const *collected) {
    for (int i = 0; i < samples; ++i) {
        *callee->clock = clocks[i];
        memcpy(callee->state, states + (size_t)i * callee->n, callee->n * sizeof(double));
        /* a function that fails writes nothing: it must not look like its last value */
        for (int r = 0; r < callee->n_results; ++r)
            for (int j = 0; j < callee->widths[r]; ++j) callee->results[r][j] = NAN;
        evaluate(callee);
        for (int r = 0; r < callee->n_results; ++r) {
            const size_t width = callee->widths[r];
            memcpy(collected[r] + i * width, callee->results[r], width * sizeof(double));
        }
    }
}
