/* Phi' = F(t) Phi by Gauss collocation in panels, F = [0 1; L D], and the slope of rows times Phi(T, 0) in F.
 *
 * Unknowns are the accelerations a_i = L_i X_i + D_i V_i at the stages of a panel of length h that begins at (x, v):
 *
 *   X_i = x + h c_i v + h^2 sum_j (A A)_ij a_j,   V_i = v + h sum_j A_ij a_j,
 *   a_i - sum_j (h A_ij D_i + h^2 (A A)_ij L_i) a_j = L_i x + (h c_i L_i + D_i) v.                               (1)
 *
 * The slope takes the transpose of the same factors backward. Matrices are stored by columns. */

#include <string.h>

typedef const int *Ints;

typedef struct {
    void (*gemm)(const char *, const char *, Ints, Ints, Ints, const double *, const double *, Ints, const double *, Ints,
                 const double *, double *, Ints);
    void (*getrf)(Ints, Ints, double *, Ints, int *, int *);
    void (*getrs)(const char *, Ints, Ints, const double *, Ints, Ints, double *, Ints, int *);
} Blas;

typedef struct {
    Blas blas;
    const double *rule, *twice; /* A and A A, (stages, stages) by rows */
    const double *nodes, *weights, *last; /* c, b and b A */
    int stages;
} Rule;

static const double ONE = 1.0, ZERO = 0.0;

/* matrix N of (1), (stages half)^2, and what stands right, R, (stages half, n) */
static void assemble(const Rule *rule, int n, double h, const double *field, double *N, double *R) {
    const int stages = rule->stages, half = n / 2, rows = stages * half;
    for (int i = 0; i < stages; ++i) {
        const double *L = field + (size_t)i * n * n + half, *D = L + (size_t)half * n;
        for (int column = 0; column < half; ++column) {
            const double *l = L + (size_t)column * n, *d = D + (size_t)column * n;
            for (int j = 0; j < stages; ++j) {
                const double once = -h * rule->rule[i * stages + j], twice = -h * h * rule->twice[i * stages + j];
                double *to = N + (size_t)(j * half + column) * rows + i * half;
                for (int r = 0; r < half; ++r) to[r] = once * d[r] + twice * l[r];
                if (i == j) to[column] += 1.0;
            }
            double *x = R + (size_t)column * rows + i * half, *v = R + (size_t)(half + column) * rows + i * half;
            for (int r = 0; r < half; ++r) {
                x[r] = l[r];
                v[r] = h * rule->nodes[i] * l[r] + d[r];
            }
        }
    }
}

/* states at the stages, (n, n) each, and at the panel's end, from its beginning and the accelerations */
static void advance(const Rule *rule, int n, double h, const double *a, double *state, double *until) {
    const int stages = rule->stages, half = n / 2;
    for (int column = 0; column < n; ++column) {
        double *x = state + (size_t)column * n, *v = x + half;
        const double *rates = a + (size_t)column * stages * half;
        for (int i = 0; i < stages; ++i) {
            double *X = until + (size_t)i * n * n + (size_t)column * n, *V = X + half;
            for (int r = 0; r < half; ++r) X[r] = x[r] + h * rule->nodes[i] * v[r], V[r] = v[r];
            for (int j = 0; j < stages; ++j) {
                const double once = h * rule->rule[i * stages + j], twice = h * h * rule->twice[i * stages + j];
                for (int r = 0; r < half; ++r) {
                    X[r] += twice * rates[j * half + r];
                    V[r] += once * rates[j * half + r];
                }
            }
        }
        for (int r = 0; r < half; ++r) x[r] += h * v[r];
        for (int j = 0; j < stages; ++j) {
            const double once = h * rule->weights[j], twice = h * h * rule->last[j];
            for (int r = 0; r < half; ++r) {
                x[r] += twice * rates[j * half + r];
                v[r] += once * rates[j * half + r];
            }
        }
    }
}

/* fields: F at all nodes, (n, n) each. Writes Phi at the nodes and at the end, and for amble_pulled the factors of N with
 * their pivots and R of every panel. work: stages half n. Returns 0, else the number of the panel that is singular. */
int amble_transported(const Rule *rule, int n, int panels, double h, const double *fields, double *until, double *whole,
                      double *factors, int *pivots, double *rights, double *work) {
    const int rows = rule->stages * (n / 2);
    int failed = 0;
    memset(whole, 0, (size_t)n * n * sizeof(double));
    for (int i = 0; i < n; ++i) whole[(size_t)i * n + i] = 1.0;
    for (int panel = 0; panel < panels; ++panel) {
        double *N = factors + (size_t)panel * rows * rows, *R = rights + (size_t)panel * rows * n;
        int *pivot = pivots + (size_t)panel * rows;
        assemble(rule, n, h, fields + (size_t)panel * rule->stages * n * n, N, R);
        rule->blas.getrf(&rows, &rows, N, &rows, pivot, &failed);
        if (failed) return panel + 1;
        rule->blas.gemm("N", "N", &rows, &n, &n, &ONE, R, &rows, whole, &n, &ZERO, work, &rows);
        rule->blas.getrs("N", &rows, &n, N, &rows, pivot, work, &rows, &failed);
        advance(rule, n, h, work, whole, until + (size_t)panel * rule->stages * n * n);
    }
    return 0;
}

/* rows: P^T, (n, count), overwritten. Writes W_k^T, (half, count) a node, with which P Phi(T, 0) changes by
 * sum_k W_k [dL dD]_k Phi(t_k, 0). work: stages half count. */
void amble_pulled(const Rule *rule, int n, int panels, double h, int count, double *rows, const double *factors,
                  const int *pivots, const double *rights, double *pulled, double *work) {
    const int stages = rule->stages, half = n / 2, size = stages * half;
    int failed = 0;
    for (int panel = panels - 1; panel >= 0; --panel) {
        double *to = pulled + (size_t)panel * size * count;
        for (int column = 0; column < count; ++column) {
            double *x = rows + (size_t)column * n, *v = x + half, *g = work + (size_t)column * size;
            for (int i = 0; i < stages; ++i) {
                const double once = h * rule->weights[i], twice = h * h * rule->last[i];
                for (int r = 0; r < half; ++r) g[i * half + r] = once * v[r] + twice * x[r];
            }
            for (int r = 0; r < half; ++r) v[r] += h * x[r];
        }
        rule->blas.getrs("T", &size, &count, factors + (size_t)panel * size * size, &size,
                         pivots + (size_t)panel * size, work, &size, &failed);
        rule->blas.gemm("T", "N", &n, &count, &size, &ONE, rights + (size_t)panel * size * n, &size, work, &size, &ONE, rows,
                        &n);
        for (int i = 0; i < stages; ++i)
            for (int column = 0; column < count; ++column)
                memcpy(to + ((size_t)i * count + column) * half, work + (size_t)column * size + i * half, half * sizeof(double));
    }
}
