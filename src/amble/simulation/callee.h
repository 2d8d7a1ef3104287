/* A function (clock, state) -> results with memory of its own. */

typedef struct {
    void *handle; /* evaluates results = function(clock, state) from and to the buffers below */
    double *clock, *state;
    double *const *results;
    const int *widths;
    int n, n_results;
} Callee;
