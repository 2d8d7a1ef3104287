/* W = sum_k (B^k)^T B^k and P = sum_k B^k (B^k)^T by doubling (Smith, SIAM J. Appl. Math. 16, 1968). */

#include <float.h>
#include <string.h>

typedef const int *Ints;
typedef void (*Gemm)(const char *, const char *, Ints, Ints, Ints, const double *, const double *, Ints, const double *, Ints,
                     const double *, double *, Ints);

static const double ONE = 1.0, ZERO = 0.0;

static double trace(const double *matrix, int m) {
    double sum = 0;
    for (int i = 0; i < m; ++i) sum += matrix[(size_t)i * m + i];
    return sum;
}

static double add(double *sum, const double *term, int m) {
    for (int i = 0; i < m * m; ++i) sum[i] += term[i];
    return trace(term, m);
}

/* power: B, (m, m) by columns, overwritten; work: 2 m^2. Returns 0 where a trace exceeds `diverged` or is no number. */
int amble_accumulated(Gemm gemm, int m, double *power, int doublings, double diverged, double *metric, double *dual,
                      double *work) {
    const size_t size = (size_t)m * m;
    double *product = work, *term = work + size;
    memset(metric, 0, size * sizeof(double));
    for (int i = 0; i < m; ++i) metric[(size_t)i * m + i] = 1.0;
    memcpy(dual, metric, size * sizeof(double));
    for (int k = 0; k < doublings; ++k) {
        gemm("N", "N", &m, &m, &m, &ONE, metric, &m, power, &m, &ZERO, product, &m);
        gemm("T", "N", &m, &m, &m, &ONE, power, &m, product, &m, &ZERO, term, &m);
        const double one = add(metric, term, m);
        gemm("N", "N", &m, &m, &m, &ONE, power, &m, dual, &m, &ZERO, product, &m);
        gemm("N", "T", &m, &m, &m, &ONE, product, &m, power, &m, &ZERO, term, &m);
        const double two = add(dual, term, m), first = trace(metric, m), second = trace(dual, m);
        if (!(first < diverged && second < diverged)) return 0;
        if ((one > two ? one : two) <= DBL_EPSILON * (first < second ? first : second)) break;
        gemm("N", "N", &m, &m, &m, &ONE, power, &m, power, &m, &ZERO, product, &m);
        memcpy(power, product, size * sizeof(double));
    }
    return 1;
}
