/* A function (clock, state) -> results with memory of its own. */

typedef struct {
    /* casadi_c_eval_id of casadi's C interface, and what it takes; arguments and results point to the buffers below */
    int (*evaluate)(int id, const double **arguments, double **results, long long *integers, double *reals, int memory);
    const double **arguments;
    double **outputs;
    long long *integers;
    double *reals;
    int id, memory;
    double *clock, *state;
    double *const *results;
    const int *widths;
    int n, n_results;
} Callee;

static int evaluate(const Callee *callee) {
    return callee->evaluate(callee->id, callee->arguments, callee->outputs, callee->integers, callee->reals, callee->memory);
}
