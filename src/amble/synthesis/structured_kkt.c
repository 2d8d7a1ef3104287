/* KKT systems of a gait problem: elimination by node, condensation by interval, one dense end with inertia.
 *
 *     [ W + Sigma_x   0        J_c'  J_d' ] [ dx  ]   [ r_x ]
 *     [ 0             Sigma_s  0    -I    ] [ ds  ] = [ r_s ]
 *     [ J_c           0        0     0    ] [ y_c ]   [ r_c ]
 *     [ J_d          -I        0     0    ] [ y_d ]   [ r_d ]
 *
 * Slacks and inequalities go into the Hessian, H = W + Sigma_x + J_d' Sigma_s J_d. At a node the explicit unknowns e
 * follow from the domain's parameters t (e = C t), the implicit ones y from as many rows (y = M [s e h], h: the
 * parameters that these rows or the node's Hessian read). The states s of an interval's later nodes follow from its
 * defect rows. What is left are the first states and the parameters of all domains, p, and the rows between domains: a
 * dense matrix, factored with Bunch-Kaufman pivots. Every elimination takes as many unknowns as rows, which adds as
 * many positive as negative eigenvalues; so the inertia of the end gives that of the whole (Haynsworth, 1968).
 *
 * Large entries of Sigma (active bounds and inequalities late in a solve) would drown what they are added to. They
 * keep a row of their own in the end instead, a' dx - z / sigma = 0 with the term a z in the rows of x; each such row
 * has one negative eigenvalue of its own.
 *
 * The functions of MA27 at the end of the file are what IPOPT calls. Matrices are stored by columns.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define REFUSED_STRUCTURE 1
#define REFUSED_REGULARISED 2
#define REFUSED_PIVOT 3
#define REFUSED_RESIDUAL 4
#define REFUSED_MEMORY 5

#define ENOUGH 1e-11 /* relative residual at which refinement ends */
#define BOUND 1e-7   /* relative residual above which a solution is refused */
#define REFINEMENTS 5
#define STIFF 1e4 /* entry of Sigma, over the regularisation of the Hessian or 1, that keeps a row of its own */

typedef const int *Ints;

typedef struct {
    void (*gemm)(const char *, const char *, Ints, Ints, Ints, const double *, const double *, Ints, const double *,
                 Ints, const double *, double *, Ints);
    void (*gemv)(const char *, Ints, Ints, const double *, const double *, Ints, const double *, Ints, const double *,
                 double *, Ints);
    void (*symm)(const char *, const char *, Ints, Ints, const double *, const double *, Ints, const double *, Ints,
                 const double *, double *, Ints);
    void (*syrk)(const char *, const char *, Ints, Ints, const double *, const double *, Ints, const double *,
                 double *, Ints);
    void (*syr2k)(const char *, const char *, Ints, Ints, const double *, const double *, Ints, const double *, Ints,
                  const double *, double *, Ints);
    void (*getrf)(Ints, Ints, double *, Ints, int *, int *);
    void (*getrs)(const char *, Ints, Ints, const double *, Ints, Ints, double *, Ints, int *);
    void (*sytrf)(const char *, Ints, double *, Ints, int *, double *, Ints, int *);
    void (*sytrs)(const char *, Ints, Ints, const double *, Ints, Ints, double *, Ints, int *);
} Blas;

typedef struct {
    int nodes, intervals, stages;  /* stages: nodes of an interval but its first */
    int ns, ne, nh, ny, nt, na, nd; /* states, explicit, read parameters, implicit, parameters, rates, of the defects */
    Ints end;                       /* (ns + nt) places of p in the end */
    Ints read;                      /* (nh) read parameters */
    Ints c_start, c_column;         /* pattern of C by rows: (ne + 1), parameters */
    Ints defect;                    /* (nd) parameters of the defect rows */
    Ints rate;                      /* (na) local places of the unknowns that the defect rows read beside states */
    Ints variable;                  /* (nodes, ns + ne + ny) variables of the program */
    Ints explicit_row, implicit_row, defect_row; /* (nodes, ne), (nodes, ny), (intervals, ns stages) equality rows */
} Domain;

typedef struct {
    int domains, variables, equalities, inequalities, end_variables, end_rows;
    int tips, cross_tips, crosses, links, end_inequalities;
    const Domain *domain;
    Ints end_index; /* (variables) place in the end of what belongs to no node, else -1 */
    Ints end_row;   /* (end_rows) equality rows */
    Ints jacobian_start, jacobian_row, jacobian_block, jacobian_place; /* by columns; rows: equalities first */
    Ints hessian_start, hessian_row, hessian_block, hessian_place;     /* by columns, upper triangle */
    Ints diagonal_block, diagonal_place;                               /* (variables) */
    Ints node_inequality, inequality_row, inequality_start, inequality_place; /* of single nodes, node by node */
    Ints variable_node, variable_place; /* (variables) of unknowns of nodes, else -1 */
    Ints tip_variable;                  /* unknowns of nodes that the end reads; those of crosses first */
    Ints cross_tip, cross_other;            /* Hessian between a tip and another or -1 - end variable */
    Ints link_row, link_tip;                /* Jacobian of the end's rows over tips */
    Ints end_inequality_row, end_inequality_start, end_inequality_column; /* columns: tip or -1 - end variable */
} Plan;

typedef struct {
    double *G, *M, *d, *C, *Hss, *Hst, *A; /* A: rates over p, (na, ns + nt) */
    int *pivots;
    const double *S; /* states over p; leading dimension ld */
    int ld;
    double *particular; /* (ns + ne + ny) states, explicit, implicit without their share of the states */
} Node;

typedef struct {
    double *A, *D, *E, *S; /* states' matrix, defect rows, E: states over the first ones, S: over p */
    int *pivots;
} Interval;

typedef struct {
    int size, nonzeros, blocks;
    int *row, *column, *source, *place, *start; /* of the triplets; grouped by block */
    int *inequality_start, *inequality_source;  /* triplets of J_d row by row */
    int *hessian_source, hessian_count;         /* triplets of W + Sigma_x */
    double *weight, *condensed, *diagonal;      /* Sigma_s; the part in the Hessian; diagonal of W + Sigma_x */
    double *work, *big;                         /* scratch of a node; scratch of an interval */
    int *stiff, *stiff_variable, stiffs;        /* with rows of their own: variables or -1 - inequality; a flag each */
    Node *node;
    Interval *interval;
    double *HD, *K, *F, *tip, *lapack, *solution, *vectors; /* K: the end; F: with stiff rows, factored */
    int *pivots, lwork;
    void **memory;
    int kept;
} Instance;

typedef struct {
    Plan plan;
    Blas blas;
    Instance *instances[8];
    int count, refused;
    long factorisations, solutions, refinements;
    double worst;
} Solver;

static __thread Solver *active;

static const double ONE = 1.0, HALF = 0.5, ZERO = 0.0, MINUS = -1.0;
static const int STEP = 1;

/* ---- the plan's sizes ---- */

static int node_width(const Domain *d) { return d->ns + d->ne + d->nh + d->ny; }
static int node_unknowns(const Domain *d) { return d->ns + d->ne + d->ny; }
static int constants(const Domain *d) { return d->c_start[d->ne]; }
static int parameters(const Domain *d) { return d->ns + d->nt; }
static int defects(const Domain *d) { return d->ns * d->stages; }
static int defect_width(const Domain *d) { return (d->stages + 1) * (d->ns + d->na) + d->nd; }

static int node_count(const Plan *p) {
    int n = 0;
    for (int d = 0; d < p->domains; d++) n += p->domain[d].nodes;
    return n;
}

static int interval_count(const Plan *p) {
    int n = 0;
    for (int d = 0; d < p->domains; d++) n += p->domain[d].intervals;
    return n;
}

/* ---- memory ---- */

static void *take(Instance *I, size_t count, size_t size, int *failed) {
    void *place = calloc(count ? count : 1, size);
    void **more = realloc(I->memory, (I->kept + 1) * sizeof(void *));
    if (more) I->memory = more;
    if (!place || !more) {
        free(place);
        *failed = 1;
        return NULL;
    }
    I->memory[I->kept++] = place;
    return place;
}

#define DOUBLES(n) take(I, (n), sizeof(double), failed)
#define INTEGERS(n) take(I, (n), sizeof(int), failed)

static void discard(Instance *I) {
    for (int i = 0; i < I->kept; i++) free(I->memory[i]);
    free(I->memory);
    free(I);
}

static size_t larger(size_t a, size_t b) { return a > b ? a : b; }

static void allocate_domain(const Domain *d, Instance *I, Node *node, Interval *interval, int *failed) {
    int n1 = d->ns + d->ne + d->nh, np = parameters(d), nd = defects(d);
    for (int k = 0; k < d->nodes; k++) {
        node[k].G = DOUBLES((size_t)d->ny * d->ny);
        node[k].M = DOUBLES((size_t)d->ny * n1);
        node[k].d = DOUBLES(d->ne);
        node[k].C = DOUBLES(constants(d));
        node[k].Hss = DOUBLES((size_t)d->ns * d->ns);
        node[k].Hst = DOUBLES((size_t)d->ns * d->nt);
        node[k].A = DOUBLES((size_t)d->na * np);
        node[k].particular = DOUBLES(node_unknowns(d));
        node[k].pivots = INTEGERS(d->ny);
    }
    double *first = DOUBLES((size_t)d->ns * np);
    if (*failed) return;
    for (int i = 0; i < d->ns; i++) first[i * d->ns + i] = 1.0;
    node[0].S = first;
    node[0].ld = d->ns;
    for (int j = 0; j < d->intervals; j++) {
        interval[j].A = DOUBLES((size_t)nd * nd);
        interval[j].D = DOUBLES((size_t)nd * defect_width(d));
        interval[j].E = DOUBLES((size_t)nd * d->ns);
        interval[j].S = DOUBLES((size_t)nd * np);
        interval[j].pivots = INTEGERS(nd);
        if (*failed) return;
        for (int s = 1; s <= d->stages; s++) {
            node[j * d->stages + s].S = interval[j].S + (s - 1) * d->ns;
            node[j * d->stages + s].ld = nd;
        }
    }
}

static void allocate(const Plan *p, Instance *I, int *failed) {
    size_t work = 1, big = 1, hd = 0;
    int nk = p->end_variables + p->end_rows;
    I->node = take(I, node_count(p), sizeof(Node), failed);
    I->interval = take(I, interval_count(p), sizeof(Interval), failed);
    if (*failed) return;
    Node *node = I->node;
    Interval *interval = I->interval;
    for (int k = 0; k < p->domains; k++) {
        const Domain *d = p->domain + k;
        size_t n = node_width(d), np = parameters(d), m = d->ne + d->nh;
        size_t q = p->inequality_start[p->node_inequality[node_count(p)]];
        work = larger(work, n * n + (size_t)d->ny * n + d->ne + constants(d) + q);
        big = larger(big, (size_t)d->ny * n + n * d->nt + (size_t)d->nt * m + d->na * n);
        big = larger(big, 2 * (size_t)defects(d) * np);
        hd += np * np;
        allocate_domain(d, I, node, interval, failed);
        if (*failed) return;
        node += d->nodes;
        interval += d->intervals;
    }
    size_t lists = (size_t)p->crosses + p->links + p->end_inequality_start[p->end_inequalities];
    I->work = DOUBLES(work);
    I->big = DOUBLES(larger(big, (size_t)p->end_variables * larger(p->tips, p->end_inequalities)));
    I->HD = DOUBLES(hd);
    I->K = DOUBLES((size_t)nk * nk + lists);
    I->tip = DOUBLES((size_t)p->end_variables * p->tips);
    nk += p->end_variables; /* at most as many stiff rows */
    I->F = DOUBLES((size_t)nk * nk);
    I->lwork = 64 * (nk + 1);
    I->lapack = DOUBLES(I->lwork);
    I->pivots = INTEGERS(nk);
    I->solution = DOUBLES(nk);
    I->weight = DOUBLES(p->inequalities);
    I->condensed = DOUBLES(p->inequalities);
    I->diagonal = DOUBLES(p->variables);
    I->stiff = INTEGERS(p->end_variables);
    I->stiff_variable = INTEGERS(p->variables);
    I->vectors = DOUBLES(7 * (size_t)I->size);
}

/* ---- structure: where every triplet goes ---- */

static int find(Ints start, Ints row, int r, int c) {
    int low = start[c], high = start[c + 1] - 1;
    while (low <= high) {
        int middle = (low + high) / 2;
        if (row[middle] == r) return middle;
        if (row[middle] < r)
            low = middle + 1;
        else
            high = middle - 1;
    }
    return -1;
}

/* Blocks beyond nodes and intervals: the end; weights; what has to be zero; what has to be -1. */
#define END 0
#define WEIGHTS 1
#define ZEROS 2
#define UNITS 3

static int locate(const Plan *p, int i, int j, int *place) {
    int x = p->variables, s = x + p->inequalities, c = s + p->equalities, end = node_count(p) + interval_count(p);
    int at = -1;
    if (i < x && i == j) {
        *place = p->diagonal_place[i];
        return p->diagonal_block[i];
    }
    if (i < x) {
        at = find(p->hessian_start, p->hessian_row, j, i);
        if (at < 0) return -1;
        *place = p->hessian_place[at];
        return p->hessian_block[at];
    }
    *place = i - x;
    if (i < s) return i == j ? end + WEIGHTS : -1;
    if (i == j) return end + ZEROS;
    if (j < x) {
        at = find(p->jacobian_start, p->jacobian_row, i - s, j);
        if (at < 0) return -1;
        *place = p->jacobian_place[at];
        return p->jacobian_block[at];
    }
    return i >= c && j - x == i - c ? end + UNITS : -1;
}

static int sort_triplets(const Plan *p, Instance *I, Ints irn, Ints icn, int *failed) {
    int nz = I->nonzeros;
    int *block = INTEGERS(nz), *where = INTEGERS(nz);
    I->blocks = node_count(p) + interval_count(p) + 4;
    I->row = INTEGERS(nz);
    I->column = INTEGERS(nz);
    I->source = INTEGERS(nz);
    I->place = INTEGERS(nz);
    I->start = INTEGERS(I->blocks + 2);
    if (*failed) return 0;
    for (int t = 0; t < nz; t++) {
        int i = irn[t] - 1, j = icn[t] - 1;
        I->row[t] = i < j ? j : i;
        I->column[t] = i < j ? i : j;
        block[t] = locate(p, I->row[t], I->column[t], where + t);
        if (block[t] < 0) return 0;
        I->start[block[t] + 2]++;
    }
    for (int b = 1; b <= I->blocks; b++) I->start[b + 1] += I->start[b];
    for (int t = 0; t < nz; t++) {
        int at = I->start[block[t] + 1]++;
        I->source[at] = t;
        I->place[at] = where[t];
    }
    return 1;
}

/* Triplets of J_d row by row, and those of W + Sigma_x. */
static void list_triplets(const Plan *p, Instance *I, int *failed) {
    int first = p->variables + p->inequalities + p->equalities, count = 0;
    for (int t = 0; t < I->nonzeros; t++) {
        count += I->row[t] >= first && I->column[t] < p->variables;
        I->hessian_count += I->row[t] < p->variables;
    }
    I->hessian_source = INTEGERS(I->hessian_count);
    I->inequality_start = INTEGERS(p->inequalities + 2);
    I->inequality_source = INTEGERS(count);
    if (*failed) return;
    int *start = I->inequality_start, *next = I->hessian_source;
    for (int t = 0; t < I->nonzeros; t++)
        if (I->row[t] < p->variables) *next++ = t;
    for (int t = 0; t < I->nonzeros; t++)
        if (I->row[t] >= first && I->column[t] < p->variables) start[I->row[t] - first + 2]++;
    for (int i = 1; i <= p->inequalities; i++) start[i + 1] += start[i];
    for (int t = 0; t < I->nonzeros; t++)
        if (I->row[t] >= first && I->column[t] < p->variables) I->inequality_source[start[I->row[t] - first + 1]++] = t;
}

static void scatter(const Instance *I, int block, const double *a, double *target) {
    for (int t = I->start[block]; t < I->start[block + 1]; t++) target[I->place[t]] += a[I->source[t]];
}

/* ---- factorisation ---- */

static void axpy(int n, double a, const double *x, double *y) {
    for (int i = 0; i < n; i++) y[i] += a * x[i];
}

static double dot(int n, const double *x, const double *y) {
    double sum = 0.0;
    for (int i = 0; i < n; i++) sum += x[i] * y[i];
    return sum;
}

/* Add the inequality rows of a node to its Hessian (lower triangle). */
static void condense(const Plan *p, const double *weight, int node, const double *value, double *H, int n) {
    int first = p->node_inequality[node];
    value -= p->inequality_start[first];
    for (int r = first; r < p->node_inequality[node + 1]; r++) {
        double w = weight[p->inequality_row[r]];
        if (w == 0.0) continue;
        for (int i = p->inequality_start[r]; i < p->inequality_start[r + 1]; i++)
            for (int j = p->inequality_start[r]; j <= i; j++) {
                int a = p->inequality_place[i], b = p->inequality_place[j];
                H[(a < b ? a : b) * n + (a < b ? b : a)] += w * value[i] * value[j];
            }
    }
}

/* Explicit and read unknowns go into the parameters: Hessian over states and parameters, rates over p. */
static void into_parameters(const Domain *d, Node *node, const double *H, int n, double *scratch, double *HD) {
    int n1 = d->ns + d->ne + d->nh, m = d->ne + d->nh, nt = d->nt, np = parameters(d);
    double *R = scratch, *T = R + (size_t)n1 * nt, *rates = T + (size_t)nt * m;
    memset(R, 0, sizeof(double) * n1 * nt);
    for (int a = 0; a < d->na; a++)
        for (int j = 0; j < n1; j++)
            rates[j * d->na + a] = d->rate[a] >= n1 ? node->M[j * d->ny + d->rate[a] - n1] : (double)(d->rate[a] == j);
    memset(node->A, 0, sizeof(double) * d->na * np);
    memcpy(node->A, rates, sizeof(double) * d->na * d->ns);
    for (int u = 0; u < m; u++) {
        int explicit = u < d->ne, first = explicit ? d->c_start[u] : 0, last = explicit ? d->c_start[u + 1] : 1;
        for (int k = first; k < last; k++) {
            int column = explicit ? d->c_column[k] : d->read[u - d->ne];
            double c = explicit ? node->C[k] : 1.0;
            axpy(n1, c, H + (size_t)(d->ns + u) * n, R + (size_t)column * n1);
            axpy(d->na, c, rates + (d->ns + u) * d->na, node->A + (d->ns + column) * d->na);
        }
    }
    for (int t = 0; t < nt; t++) {
        memcpy(node->Hst + t * d->ns, R + (size_t)t * n1, sizeof(double) * d->ns);
        for (int u = 0; u < m; u++) T[(size_t)u * nt + t] = R[(size_t)t * n1 + d->ns + u];
    }
    for (int u = 0; u < m; u++) {
        int explicit = u < d->ne, first = explicit ? d->c_start[u] : 0, last = explicit ? d->c_start[u + 1] : 1;
        for (int k = first; k < last; k++) {
            int column = explicit ? d->c_column[k] : d->read[u - d->ne];
            double c = explicit ? node->C[k] : 1.0;
            axpy(nt - column, c, T + (size_t)u * nt + column, HD + (size_t)(d->ns + column) * np + d->ns + column);
        }
    }
    for (int j = 0; j < d->ns; j++) memcpy(node->Hss + j * d->ns, H + (size_t)j * n, sizeof(double) * d->ns);
}

static int factor_node(Solver *solver, Instance *I, const Domain *d, int number, Ints variable, const double *a,
                       double *HD) {
    const Blas *blas = &solver->blas;
    Node *node = I->node + number;
    int n = node_width(d), n1 = n - d->ny, ny = d->ny, failed = 0;
    double *H = I->work, *J = H + (size_t)n * n, *diagonal = J + (size_t)ny * n, *constant = diagonal + d->ne;
    double *X = I->big;
    int first = solver->plan.node_inequality[number], last = solver->plan.node_inequality[number + 1];
    int values = solver->plan.inequality_start[last] - solver->plan.inequality_start[first];
    memset(H, 0, sizeof(double) * ((size_t)n * n + (size_t)ny * n + d->ne + constants(d) + values));
    scatter(I, number, a, H);
    int unknowns = node_unknowns(d), before = d->ns + d->ne;
    for (int i = 0; i < unknowns; i++) { /* a diagonal with a row of its own is no part of the Hessian */
        size_t place = i < before ? i : i + d->nh;
        if (I->stiff_variable[variable[i]]) H[place * (n + 1)] = 0.0;
    }
    condense(&solver->plan, I->condensed, number, constant + constants(d), H, n);
    for (int i = 0; i < d->ne; i++) {
        node->d[i] = diagonal[i];
        if (!(fabs(diagonal[i]) > 0.0)) return 0;
        for (int k = d->c_start[i]; k < d->c_start[i + 1]; k++) node->C[k] = -constant[k] / diagonal[i];
    }
    memcpy(node->G, J + (size_t)ny * n1, sizeof(double) * ny * ny);
    for (int i = 0; i < ny * n1; i++) node->M[i] = -J[i];
    if (ny) {
        blas->getrf(&ny, &ny, node->G, &ny, node->pivots, &failed);
        if (failed) return 0;
        blas->getrs("N", &ny, &n1, node->G, &ny, node->pivots, node->M, &ny, &failed);
        for (int j = 0; j < n1; j++) memcpy(X + (size_t)j * ny, H + (size_t)j * n + n1, sizeof(double) * ny);
        blas->symm("L", "L", &ny, &n1, &HALF, H + (size_t)n1 * n + n1, &n, node->M, &ny, &ONE, X, &ny);
        blas->syr2k("L", "T", &n1, &ny, &ONE, node->M, &ny, X, &ny, &ONE, H, &n);
    }
    for (int j = 0; j < n1; j++)
        for (int i = j + 1; i < n1; i++) H[(size_t)i * n + j] = H[(size_t)j * n + i];
    into_parameters(d, node, H, n, I->big, HD);
    return 1;
}

/* The states of an interval's later nodes over its first ones and the parameters, then over p; their Hessian. */
static int factor_interval(Solver *solver, Instance *I, const Domain *d, int first_node, int number, int block,
                           const double *a, double *HD) {
    const Blas *blas = &solver->blas;
    const Node *node = I->node + first_node;
    Interval *interval = I->interval + number;
    int nd = defects(d), np = parameters(d), ns = d->ns, nt = d->nt, na = d->na, failed = 0;
    double *D = interval->D, *E = I->big, *R = E + (size_t)nd * np, *S = interval->S;
    memset(D, 0, sizeof(double) * nd * defect_width(d));
    scatter(I, block, a, D);
    memcpy(interval->A, D + (size_t)ns * nd, sizeof(double) * nd * nd);
    memset(E, 0, sizeof(double) * nd * np);
    for (int i = 0; i < nd * ns; i++) E[i] = -D[i];
    const double *rates = D + (size_t)(d->stages + 1) * ns * nd, *shared = rates + (size_t)(d->stages + 1) * na * nd;
    for (int k = 0; k < d->nd; k++) axpy(nd, -1.0, shared + (size_t)k * nd, E + (size_t)(ns + d->defect[k]) * nd);
    for (int s = 0; s <= d->stages; s++, rates += (size_t)na * nd) {
        if (s == 0) {
            blas->gemm("N", "N", &nd, &np, &na, &MINUS, rates, &nd, node[s].A, &na, &ONE, E, &nd);
            continue;
        }
        double *states = interval->A + (size_t)(s - 1) * ns * nd;
        blas->gemm("N", "N", &nd, &ns, &na, &ONE, rates, &nd, node[s].A, &na, &ONE, states, &nd);
        double *shares = E + (size_t)ns * nd;
        blas->gemm("N", "N", &nd, &nt, &na, &MINUS, rates, &nd, node[s].A + ns * na, &na, &ONE, shares, &nd);
    }
    blas->getrf(&nd, &nd, interval->A, &nd, interval->pivots, &failed);
    if (failed) return 0;
    blas->getrs("N", &nd, &np, interval->A, &nd, interval->pivots, E, &nd, &failed);
    memcpy(interval->E, E, sizeof(double) * nd * ns);
    memset(S, 0, sizeof(double) * nd * ns);
    memcpy(S + (size_t)nd * ns, E + (size_t)nd * ns, sizeof(double) * nd * nt);
    blas->gemm("N", "N", &nd, &np, &ns, &ONE, E, &nd, node[0].S, &node[0].ld, &ONE, S, &nd);
    memset(R, 0, sizeof(double) * nd * ns);
    for (int s = 1; s <= d->stages; s++)
        for (int j = 0; j < nt; j++)
            memcpy(R + (size_t)(ns + j) * nd + (s - 1) * ns, node[s].Hst + j * ns, sizeof(double) * ns);
    for (int s = 1; s <= d->stages; s++)
        blas->gemm("N", "N", &ns, &np, &ns, &HALF, node[s].Hss, &ns, node[s].S, &nd, &ONE, R + (s - 1) * ns, &nd);
    blas->syr2k("L", "T", &np, &nd, &ONE, S, &nd, R, &nd, &ONE, HD, &np);
    return 1;
}

/* Add the gradient of a variable over those of the end, times a factor. */
static void add_gradient(const Plan *p, const Instance *I, int variable, double factor, double *column) {
    int number = p->variable_node[variable], place = p->variable_place[variable], first = 0, k = 0;
    if (p->end_index[variable] >= 0) {
        column[p->end_index[variable]] += factor;
        return;
    }
    while (number >= first + p->domain[k].nodes) first += p->domain[k++].nodes;
    const Domain *d = p->domain + k;
    const Node *node = I->node + number;
    int n1 = d->ns + d->ne + d->nh, before = d->ns + d->ne, np = parameters(d);
    for (int j = 0; j < n1; j++) {
        double share = factor * (place >= n1 ? node->M[(size_t)j * d->ny + place - n1] : (double)(place == j));
        if (share == 0.0) continue;
        if (j < d->ns)
            for (int i = 0; i < np; i++) column[d->end[i]] += share * node->S[(size_t)i * node->ld + j];
        else if (j < before)
            for (int i = d->c_start[j - d->ns]; i < d->c_start[j - d->ns + 1]; i++)
                column[d->end[d->ns + d->c_column[i]]] += share * node->C[i];
        else
            column[d->end[d->ns + d->read[j - before]]] += share;
    }
}

static void assemble_end(Solver *solver, Instance *I) {
    const Plan *p = &solver->plan;
    const Blas *blas = &solver->blas;
    int nf = p->end_variables, nk = nf + p->end_rows;
    double *K = I->K, *HD = I->HD, *cross = K + (size_t)nk * nk, *link = cross + p->crosses, *value = link + p->links;
    for (int k = 0; k < p->domains; k++) {
        const Domain *d = p->domain + k;
        int np = parameters(d);
        for (int j = 0; j < np; j++)
            for (int i = j; i < np; i++) {
                int r = d->end[i], c = d->end[j];
                K[(size_t)(r < c ? r : c) * nk + (r < c ? c : r)] += HD[(size_t)j * np + i];
            }
        HD += (size_t)np * np;
    }
    memset(I->tip, 0, sizeof(double) * nf * p->tips);
    for (int t = 0; t < p->tips; t++) add_gradient(p, I, p->tip_variable[t], 1.0, I->tip + (size_t)t * nf);
    double *W = I->big;
    memset(W, 0, sizeof(double) * nf * p->cross_tips);
    for (int k = 0; k < p->crosses; k++) {
        double *column = W + (size_t)p->cross_tip[k] * nf;
        if (p->cross_other[k] >= 0)
            axpy(nf, cross[k], I->tip + (size_t)p->cross_other[k] * nf, column);
        else
            column[-1 - p->cross_other[k]] += cross[k];
    }
    if (p->cross_tips) blas->syr2k("L", "N", &nf, &p->cross_tips, &ONE, I->tip, &nf, W, &nf, &ONE, K, &nk);
    for (int k = 0; k < p->links; k++)
        for (int j = 0; j < nf; j++)
            K[(size_t)j * nk + nf + p->link_row[k]] += link[k] * I->tip[(size_t)p->link_tip[k] * nf + j];
    memset(W, 0, sizeof(double) * nf * p->end_inequalities);
    for (int r = 0; r < p->end_inequalities; r++) {
        double root = sqrt(I->condensed[p->end_inequality_row[r]]), *column = W + (size_t)r * nf;
        for (int k = p->end_inequality_start[r]; k < p->end_inequality_start[r + 1]; k++) {
            int at = p->end_inequality_column[k];
            if (at >= 0)
                axpy(nf, root * value[k], I->tip + (size_t)at * nf, column);
            else
                column[-1 - at] += root * value[k];
        }
    }
    if (p->end_inequalities) blas->syrk("L", "N", &nf, &p->end_inequalities, &ONE, W, &nf, &ONE, K, &nk);
}

/* Signs of the pivots of a Bunch-Kaufman factor: negative ones; -1 where one is zero, -2 where one is no number. */
static int negative(const double *K, Ints pivots, int n) {
    int count = 0;
    for (int i = 0; i < n; i++) {
        double a = K[(size_t)i * (n + 1)];
        if (pivots[i] > 0) {
            if (a == 0.0) return -1;
            if (!isfinite(a)) return -2;
            count += a < 0.0;
            continue;
        }
        double b = K[(size_t)i * n + i + 1], c = K[(size_t)(i + 1) * (n + 1)];
        /* a c - b^2 without overflow; Bunch-Kaufman takes pairs whose b is the largest */
        double determinant = b == 0.0 ? a * c : (a / b) * (c / b) - 1.0;
        if (!isfinite(determinant)) return -2;
        if (determinant == 0.0) return -1;
        count += determinant < 0.0 ? 1 : (a < 0.0 ? 2 : 0);
        i++;
    }
    return count;
}

static int weights(const Plan *p, Instance *I, const double *a) {
    int end = I->blocks - 4;
    memset(I->weight, 0, sizeof(double) * p->inequalities);
    scatter(I, end + WEIGHTS, a, I->weight);
    for (int i = 0; i < p->inequalities; i++)
        if (!(I->weight[i] >= 0.0)) return REFUSED_PIVOT;
    for (int t = I->start[end + ZEROS]; t < I->start[end + ZEROS + 1]; t++)
        if (a[I->source[t]] != 0.0) return REFUSED_REGULARISED;
    for (int t = I->start[end + UNITS]; t < I->start[end + UNITS + 1]; t++)
        if (a[I->source[t]] != -1.0) return REFUSED_STRUCTURE;
    return 0;
}

/* Choose what gets a row of its own: at most as much as the end has variables, the largest entries. */
static void choose_stiff(const Plan *p, Instance *I, const double *a) {
    int nx = p->variables;
    double least = INFINITY, limit;
    memset(I->diagonal, 0, sizeof(double) * nx);
    for (int k = 0; k < I->hessian_count; k++) {
        int t = I->hessian_source[k];
        if (I->row[t] == I->column[t]) I->diagonal[I->row[t]] += a[t];
    }
    for (int i = 0; i < nx; i++) least = fmin(least, I->diagonal[i]);
    for (limit = STIFF * fmax(1.0, least);; limit *= 10.0) {
        int count = 0;
        for (int i = 0; i < nx; i++) count += p->end_index[i] < 0 && I->diagonal[i] > limit;
        for (int i = 0; i < p->inequalities; i++) count += I->weight[i] > limit;
        if (count <= p->end_variables) break;
    }
    I->stiffs = 0;
    for (int i = 0; i < nx; i++) {
        I->stiff_variable[i] = p->end_index[i] < 0 && I->diagonal[i] > limit;
        if (I->stiff_variable[i]) I->stiff[I->stiffs++] = i;
    }
    for (int i = 0; i < p->inequalities; i++) {
        I->condensed[i] = I->weight[i] > limit ? 0.0 : I->weight[i];
        if (I->weight[i] > limit) I->stiff[I->stiffs++] = -1 - i;
    }
}

/* The end with the stiff rows below, factored. */
static int factor_end(Solver *solver, Instance *I, const double *a) {
    const Plan *p = &solver->plan;
    int nf = p->end_variables, nk = nf + p->end_rows, n = nk + I->stiffs, info = 0;
    memset(I->F, 0, sizeof(double) * n * n);
    for (int j = 0; j < nk; j++) memcpy(I->F + (size_t)j * n + j, I->K + (size_t)j * nk + j, sizeof(double) * (nk - j));
    for (int k = 0; k < I->stiffs; k++) {
        double *gradient = I->lapack;
        int which = I->stiff[k];
        memset(gradient, 0, sizeof(double) * nf);
        if (which >= 0)
            add_gradient(p, I, which, 1.0, gradient);
        else
            for (int t = I->inequality_start[-1 - which]; t < I->inequality_start[-which]; t++) {
                int from = I->inequality_source[t];
                add_gradient(p, I, I->column[from], a[from], gradient);
            }
        for (int j = 0; j < nf; j++) I->F[(size_t)j * n + nk + k] = gradient[j];
        I->F[(size_t)(nk + k) * (n + 1)] = -1.0 / (which >= 0 ? I->diagonal[which] : I->weight[-1 - which]);
    }
    solver->blas.sytrf("L", &n, I->F, &n, I->pivots, I->lapack, &I->lwork, &info);
    if (info > 0) return -1;
    int count = negative(I->F, I->pivots, n);
    if (count == -2) return -1 - REFUSED_PIVOT;
    return count < 0 ? -1 : count + p->inequalities + p->equalities - p->end_rows - I->stiffs;
}

/* Returns the number of negative eigenvalues; -1 where the matrix is singular; -1 - reason where it is refused. */
static int factor(Solver *solver, Instance *I, const double *a) {
    const Plan *p = &solver->plan;
    int nk = p->end_variables + p->end_rows, node = 0, interval = 0, nodes = node_count(p);
    int reason = weights(p, I, a);
    if (reason) return -1 - reason;
    choose_stiff(p, I, a);
    size_t lists = p->crosses + p->links + p->end_inequality_start[p->end_inequalities];
    memset(I->K, 0, sizeof(double) * ((size_t)nk * nk + lists));
    scatter(I, I->blocks - 4 + END, a, I->K);
    double *HD = I->HD;
    for (int k = 0; k < p->domains; k++) {
        const Domain *d = p->domain + k;
        int np = parameters(d);
        memset(HD, 0, sizeof(double) * np * np);
        for (int i = 0; i < d->nodes; i++)
            if (!factor_node(solver, I, d, node + i, d->variable + i * node_unknowns(d), a, HD))
                return -1 - REFUSED_PIVOT;
        const Node *first = I->node + node;
        for (int j = 0; j < d->ns; j++) {
            for (int i = j; i < d->ns; i++) HD[(size_t)j * np + i] += first->Hss[j * d->ns + i];
            for (int i = 0; i < d->nt; i++) HD[(size_t)j * np + d->ns + i] += first->Hst[i * d->ns + j];
        }
        for (int i = 0; i < d->intervals; i++)
            if (!factor_interval(solver, I, d, node + i * d->stages, interval + i, nodes + interval + i, a, HD))
                return -1 - REFUSED_PIVOT;
        node += d->nodes;
        interval += d->intervals;
        HD += (size_t)np * np;
    }
    assemble_end(solver, I);
    return factor_end(solver, I, a);
}

/* ---- solution ---- */

/* a' x, and x -= a z: a is a unit vector or, below zero, an inequality's row. */
static double row_product(const Instance *I, const double *a, int which, const double *x) {
    double sum = 0.0;
    if (which >= 0) return x[which];
    for (int t = I->inequality_start[-1 - which]; t < I->inequality_start[-which]; t++)
        sum += a[I->inequality_source[t]] * x[I->column[I->inequality_source[t]]];
    return sum;
}

static void subtract_row(const Instance *I, const double *a, int which, double z, double *x) {
    if (which >= 0) {
        x[which] -= z;
        return;
    }
    for (int t = I->inequality_start[-1 - which]; t < I->inequality_start[-which]; t++)
        x[I->column[I->inequality_source[t]]] -= a[I->inequality_source[t]] * z;
}

/* y -= H x with H = W + Sigma_x + J_d' Sigma_s J_d without what is stiff. The rows J_d x are left in rows. */
static void subtract_hessian(const Plan *p, const Instance *I, const double *a, const double *x, double *y,
                             double *rows) {
    for (int k = 0; k < I->hessian_count; k++) {
        int t = I->hessian_source[k], i = I->row[t], j = I->column[t];
        if (i != j || !I->stiff_variable[i]) y[i] -= a[t] * x[j];
        if (i != j) y[j] -= a[t] * x[i];
    }
    for (int i = 0; i < p->inequalities; i++) {
        rows[i] = row_product(I, a, -1 - i, x);
        if (I->condensed[i] * rows[i] != 0.0) subtract_row(I, a, -1 - i, I->condensed[i] * rows[i], y);
    }
}

/* Unknowns that meet the equality rows with all variables of the end at zero: x. */
static void particular(Solver *solver, Instance *I, const double *r, double *x) {
    const Plan *p = &solver->plan;
    const Blas *blas = &solver->blas;
    Node *node = I->node;
    Interval *interval = I->interval;
    for (int k = 0; k < p->domains; k++) {
        const Domain *d = p->domain + k;
        int ns = d->ns, ne = d->ne, ny = d->ny, na = d->na, nd = defects(d), unknowns = node_unknowns(d), info;
        int n1 = ns + ne + d->nh;
        for (int i = 0; i < d->nodes; i++) {
            double *e = node[i].particular + ns, *y = e + ne;
            for (int j = 0; j < ne; j++) e[j] = r[d->explicit_row[i * ne + j]] / node[i].d[j];
            for (int j = 0; j < ny; j++) y[j] = r[d->implicit_row[i * ny + j]];
            if (ny) blas->getrs("N", &ny, &STEP, node[i].G, &ny, node[i].pivots, y, &ny, &info);
            if (ny && ne) blas->gemv("N", &ny, &ne, &ONE, node[i].M + ns * ny, &ny, e, &STEP, &ONE, y, &STEP);
        }
        memset(node[0].particular, 0, sizeof(double) * ns);
        for (int j = 0; j < d->intervals; j++) {
            double *b = I->work;
            const double *rates = interval[j].D + (size_t)(d->stages + 1) * ns * nd;
            for (int i = 0; i < nd; i++) b[i] = r[d->defect_row[j * nd + i]];
            for (int s = 0; s <= d->stages; s++)
                for (int i = 0; i < na; i++) {
                    int place = d->rate[i] >= n1 ? d->rate[i] - d->nh : d->rate[i];
                    double rate = node[j * d->stages + s].particular[place];
                    if (place >= ns && rate != 0.0) axpy(nd, -rate, rates + (size_t)(s * na + i) * nd, b);
                }
            blas->getrs("N", &nd, &STEP, interval[j].A, &nd, interval[j].pivots, b, &nd, &info);
            blas->gemv("N", &nd, &ns, &ONE, interval[j].E, &nd, node[j * d->stages].particular, &STEP, &ONE, b, &STEP);
            for (int s = 1; s <= d->stages; s++)
                memcpy(node[j * d->stages + s].particular, b + (s - 1) * ns, sizeof(double) * ns);
        }
        for (int i = 0; i < d->nodes; i++) {
            const double *own = node[i].particular;
            double *y = I->work;
            memcpy(y, own + ns + ne, sizeof(double) * ny);
            if (ny) blas->gemv("N", &ny, &ns, &ONE, node[i].M, &ny, own, &STEP, &ONE, y, &STEP);
            for (int j = 0; j < unknowns; j++)
                x[d->variable[i * unknowns + j]] = j < ns + ne ? own[j] : y[j - ns - ne];
        }
        node += d->nodes;
        interval += d->intervals;
    }
}

/* Gradient of the end's variables that follows from one of all variables. */
static void project(Solver *solver, Instance *I, const double *w, double *end) {
    const Plan *p = &solver->plan;
    const Blas *blas = &solver->blas;
    const Node *node = I->node;
    for (int i = 0; i < p->variables; i++)
        if (p->end_index[i] >= 0) end[p->end_index[i]] = w[i];
    for (int k = 0; k < p->domains; k++) {
        const Domain *d = p->domain + k;
        int ns = d->ns, ne = d->ne, ny = d->ny, n1 = ns + ne + d->nh, np = parameters(d), unknowns = node_unknowns(d);
        double *z = I->work, *y = z + n1, *sum = y + ny;
        memset(sum, 0, sizeof(double) * np);
        for (int i = 0; i < d->nodes; i++) {
            Ints at = d->variable + i * unknowns;
            for (int j = 0; j < n1; j++) z[j] = j < ns + ne ? w[at[j]] : 0.0;
            for (int j = 0; j < ny; j++) y[j] = w[at[ns + ne + j]];
            if (ny) blas->gemv("T", &ny, &n1, &ONE, node[i].M, &ny, y, &STEP, &ONE, z, &STEP);
            blas->gemv("T", &ns, &np, &ONE, node[i].S, &node[i].ld, z, &STEP, &ONE, sum, &STEP);
            for (int j = 0; j < ne; j++)
                for (int c = d->c_start[j]; c < d->c_start[j + 1]; c++)
                    sum[ns + d->c_column[c]] += node[i].C[c] * z[ns + j];
            for (int j = 0; j < d->nh; j++) sum[ns + d->read[j]] += z[ns + ne + j];
        }
        for (int j = 0; j < np; j++) end[d->end[j]] += sum[j];
        node += d->nodes;
    }
}

/* All variables from those of the end. */
static void extend(Solver *solver, Instance *I, const double *end, double *x) {
    const Plan *p = &solver->plan;
    const Blas *blas = &solver->blas;
    const Node *node = I->node;
    for (int i = 0; i < p->variables; i++)
        if (p->end_index[i] >= 0) x[i] = end[p->end_index[i]];
    for (int k = 0; k < p->domains; k++) {
        const Domain *d = p->domain + k;
        int ns = d->ns, ne = d->ne, ny = d->ny, n1 = ns + ne + d->nh, np = parameters(d), unknowns = node_unknowns(d);
        double *q = I->work, *z = q + np, *y = z + n1;
        for (int j = 0; j < np; j++) q[j] = end[d->end[j]];
        for (int i = 0; i < d->nodes; i++) {
            const double *own = node[i].particular;
            Ints at = d->variable + i * unknowns;
            memcpy(z, own, sizeof(double) * ns);
            blas->gemv("N", &ns, &np, &ONE, node[i].S, &node[i].ld, q, &STEP, &ONE, z, &STEP);
            for (int j = 0; j < ne; j++) {
                double sum = 0.0;
                for (int c = d->c_start[j]; c < d->c_start[j + 1]; c++) sum += node[i].C[c] * q[ns + d->c_column[c]];
                z[ns + j] = sum;
            }
            for (int j = 0; j < d->nh; j++) z[ns + ne + j] = q[ns + d->read[j]];
            memcpy(y, own + ns + ne, sizeof(double) * ny);
            if (ny) blas->gemv("N", &ny, &n1, &ONE, node[i].M, &ny, z, &STEP, &ONE, y, &STEP);
            for (int j = 0; j < ns; j++) x[at[j]] = z[j];
            for (int j = 0; j < ne; j++) x[at[ns + j]] = z[ns + j] + own[ns + j];
            for (int j = 0; j < ny; j++) x[at[ns + ne + j]] = y[j];
        }
        node += d->nodes;
    }
}

/* Multipliers of the rows of nodes and intervals from the stationarity of their unknowns; w: what the end leaves. */
static void multipliers(Solver *solver, Instance *I, double *w, double *y) {
    const Plan *p = &solver->plan;
    const Blas *blas = &solver->blas;
    const Node *node = I->node;
    const Interval *interval = I->interval;
    for (int k = 0; k < p->domains; k++) {
        const Domain *d = p->domain + k;
        int ns = d->ns, ne = d->ne, ny = d->ny, na = d->na, nd = defects(d), unknowns = node_unknowns(d), info;
        int n1 = ns + ne + d->nh;
        double *b = I->work, *own = b + nd, *back = own + unknowns;
        for (int j = d->intervals - 1; j >= 0; j--) {
            for (int s = 1; s <= d->stages; s++) {
                Ints at = d->variable + (j * d->stages + s) * unknowns;
                for (int i = 0; i < unknowns; i++) own[i] = w[at[i]];
                memcpy(b + (s - 1) * ns, own, sizeof(double) * ns);
                const double *M = node[j * d->stages + s].M;
                if (ny) blas->gemv("T", &ny, &ns, &ONE, M, &ny, own + ns + ne, &STEP, &ONE, b + (s - 1) * ns, &STEP);
            }
            blas->getrs("T", &nd, &STEP, interval[j].A, &nd, interval[j].pivots, b, &nd, &info);
            for (int i = 0; i < nd; i++) y[d->defect_row[j * nd + i]] = b[i];
            const double *D = interval[j].D, *rates = D + (size_t)(d->stages + 1) * ns * nd;
            for (int s = 0; s <= d->stages; s++) {
                Ints at = d->variable + (j * d->stages + s) * unknowns;
                blas->gemv("T", &nd, &ns, &ONE, D + (size_t)s * ns * nd, &nd, b, &STEP, &ZERO, back, &STEP);
                for (int i = 0; i < ns; i++) w[at[i]] -= back[i];
                for (int i = 0; i < na; i++)
                    w[at[d->rate[i] >= n1 ? d->rate[i] - d->nh : d->rate[i]]] -=
                        dot(nd, rates + (size_t)(s * na + i) * nd, b);
            }
        }
        for (int i = 0; i < d->nodes; i++) {
            Ints at = d->variable + i * unknowns;
            for (int j = 0; j < unknowns; j++) own[j] = w[at[j]];
            if (ny && ne)
                blas->gemv("T", &ny, &ne, &ONE, node[i].M + ns * ny, &ny, own + ns + ne, &STEP, &ONE, own + ns, &STEP);
            for (int j = 0; j < ne; j++) y[d->explicit_row[i * ne + j]] = own[ns + j] / node[i].d[j];
            if (ny) blas->getrs("T", &ny, &STEP, node[i].G, &ny, node[i].pivots, own + ns + ne, &ny, &info);
            for (int j = 0; j < ny; j++) y[d->implicit_row[i * ny + j]] = own[ns + ne + j];
        }
        node += d->nodes;
        interval += d->intervals;
    }
}

/* Solve once: out of r, in the order of the rows of the whole matrix. */
static void solve_once(Solver *solver, Instance *I, const double *a, const double *r, double *out) {
    const Plan *p = &solver->plan;
    int nx = p->variables, ni = p->inequalities, nc = p->equalities, nf = p->end_variables;
    int nk = nf + p->end_rows, n = nk + I->stiffs, info;
    const double *rs = r + nx, *rc = rs + ni, *rd = rc + nc, *link = I->K + (size_t)nk * nk + p->crosses;
    double *x = out, *y = out + nx + ni, *b = I->vectors, *w = b + I->size, *rows = w + I->size, *end = I->solution;
    memcpy(b, r, sizeof(double) * nx);
    for (int i = 0; i < ni; i++)
        if (I->condensed[i] == I->weight[i]) subtract_row(I, a, -1 - i, -(I->weight[i] * rd[i] + rs[i]), b);
    memset(x, 0, sizeof(double) * nx);
    particular(solver, I, rc, x);
    memcpy(w, b, sizeof(double) * nx);
    subtract_hessian(p, I, a, x, w, rows);
    memset(end, 0, sizeof(double) * n);
    project(solver, I, w, end);
    for (int i = 0; i < p->end_rows; i++) end[nf + i] = rc[p->end_row[i]];
    for (int k = 0; k < p->links; k++) end[nf + p->link_row[k]] -= link[k] * x[p->tip_variable[p->link_tip[k]]];
    for (int k = 0; k < I->stiffs; k++) {
        int which = I->stiff[k], d = -1 - which;
        end[nk + k] = (which < 0 ? rd[d] + rs[d] / I->weight[d] : 0.0) - row_product(I, a, which, x);
    }
    solver->blas.sytrs("L", &n, &STEP, I->F, &n, I->pivots, end, &n, &info);
    extend(solver, I, end, x);
    memcpy(w, b, sizeof(double) * nx);
    subtract_hessian(p, I, a, x, w, rows);
    for (int i = 0; i < p->end_rows; i++) y[p->end_row[i]] = end[nf + i];
    for (int k = 0; k < p->links; k++) w[p->tip_variable[p->link_tip[k]]] -= link[k] * end[nf + p->link_row[k]];
    for (int k = 0; k < I->stiffs; k++) subtract_row(I, a, I->stiff[k], end[nk + k], w);
    multipliers(solver, I, w, y);
    for (int i = 0; i < ni; i++) {
        out[nx + i] = rows[i] - rd[i];
        out[nx + ni + nc + i] = I->weight[i] * (rows[i] - rd[i]) - rs[i];
    }
    for (int k = 0; k < I->stiffs; k++) {
        int d = -1 - I->stiff[k];
        if (d < 0) { /* sigma x is z to the last digit, however small x is */
            x[I->stiff[k]] = end[nk + k] / I->diagonal[I->stiff[k]];
            continue;
        }
        out[nx + ni + nc + d] = end[nk + k];
        out[nx + d] = (end[nk + k] + rs[d]) / I->weight[d];
    }
}

/* r -= K x; returns the largest entry of r over that of |K| |x| and the right side. */
static double residual(const Instance *I, const double *a, const double *x, double *r, double *size) {
    double largest = 0.0, scale = 0.0;
    for (int i = 0; i < I->size; i++) size[i] = fabs(r[i]);
    for (int t = 0; t < I->nonzeros; t++) {
        int i = I->row[t], j = I->column[t];
        double one = a[t] * x[j], other = a[t] * x[i];
        r[i] -= one;
        size[i] += fabs(one);
        if (i == j) continue;
        r[j] -= other;
        size[j] += fabs(other);
    }
    for (int i = 0; i < I->size; i++) {
        if (!isfinite(r[i])) return INFINITY;
        largest = fmax(largest, fabs(r[i]));
        scale = fmax(scale, size[i]);
    }
    return scale > 0.0 ? largest / scale : 0.0;
}

/* Solve with refinement; false where the residual does not meet its bound. */
static int solve(Solver *solver, Instance *I, const double *a, double *right) {
    int n = I->size;
    double *r = I->vectors + 3 * (size_t)n, *step = r + n, *size = step + n;
    double *found = size + n, before = INFINITY;
    memset(found, 0, sizeof(double) * n);
    memcpy(r, right, sizeof(double) * n);
    int good = 0;
    for (int k = 0; k <= REFINEMENTS; k++) {
        solve_once(solver, I, a, r, step);
        for (int i = 0; i < n; i++) step[i] += found[i];
        memcpy(r, right, sizeof(double) * n);
        double now = residual(I, a, step, r, size);
        if (!(now < before)) break; /* the last step was no gain */
        memcpy(found, step, sizeof(double) * n);
        before = now;
        good = now <= BOUND;
        solver->refinements += k > 0;
        if (now <= ENOUGH) break;
    }
    solver->worst = fmax(solver->worst, before);
    memcpy(right, found, sizeof(double) * n);
    return good;
}

/* ---- what Python calls ---- */

Solver *amble_kkt_new(const Plan *plan, const Blas *blas) {
    Solver *solver = calloc(1, sizeof(Solver));
    if (!solver) return NULL;
    solver->plan = *plan;
    solver->blas = *blas;
    return solver;
}

void amble_kkt_free(Solver *solver) {
    for (int i = 0; i < solver->count; i++) discard(solver->instances[i]);
    free(solver);
}

/* Make a solver that of this thread; returns the one before. */
Solver *amble_kkt_use(Solver *solver) {
    Solver *before = active;
    active = solver;
    return before;
}

/* Reason of a refusal or 0; counts: factorisations, solutions, refinements; the largest residual. */
int amble_kkt_report(const Solver *solver, long *counts, double *worst) {
    counts[0] = solver->factorisations;
    counts[1] = solver->solutions;
    counts[2] = solver->refinements;
    *worst = solver->worst;
    return solver->refused;
}

/* ---- the interface of MA27 ---- */

static void refuse(Solver *solver, int reason, int *info) {
    if (solver && !solver->refused) solver->refused = reason;
    info[0] = -100;
}

void ma27id_(int *icntl, double *cntl) {
    memset(icntl, 0, 30 * sizeof(int));
    memset(cntl, 0, 5 * sizeof(double));
}

void ma27ad_(Ints n, Ints nz, Ints irn, Ints icn, int *iw, Ints liw, int *ikeep, int *iw1, int *nsteps, int *iflag,
             Ints icntl, const double *cntl, int *info, double *ops) {
    Solver *solver = active;
    int problem = 0, *failed = &problem;
    (void)iw, (void)liw, (void)iw1, (void)iflag, (void)icntl, (void)cntl;
    memset(info, 0, 20 * sizeof(int));
    info[4] = info[5] = *nz;
    *nsteps = 1;
    *ops = 0.0;
    if (!solver || solver->refused || solver->count == 8) {
        refuse(solver, REFUSED_STRUCTURE, info);
        return;
    }
    const Plan *p = &solver->plan;
    Instance *I = *n == p->variables + p->equalities + 2 * p->inequalities ? calloc(1, sizeof(Instance)) : NULL;
    if (!I) {
        refuse(solver, REFUSED_STRUCTURE, info);
        return;
    }
    ikeep[0] = solver->count;
    solver->instances[solver->count++] = I;
    I->size = *n;
    I->nonzeros = *nz;
    int fits = sort_triplets(p, I, irn, icn, failed);
    if (fits) allocate(p, I, failed);
    if (fits && !problem) list_triplets(p, I, failed);
    if (problem || !fits) refuse(solver, problem ? REFUSED_MEMORY : REFUSED_STRUCTURE, info);
}

void ma27bd_(Ints n, Ints nz, Ints irn, Ints icn, double *a, Ints la, int *iw, Ints liw, Ints ikeep, Ints nsteps,
             int *maxfrt, int *iw1, Ints icntl, const double *cntl, int *info) {
    Solver *solver = active;
    (void)n, (void)nz, (void)irn, (void)icn, (void)la, (void)liw, (void)nsteps, (void)iw1, (void)icntl, (void)cntl;
    memset(info, 0, 20 * sizeof(int));
    *maxfrt = 1;
    if (!solver || solver->refused) {
        refuse(solver, REFUSED_STRUCTURE, info);
        return;
    }
    iw[0] = ikeep[0];
    solver->factorisations++;
    int count = factor(solver, solver->instances[ikeep[0]], a);
    if (count < -1)
        refuse(solver, -1 - count, info);
    else if (count == -1)
        info[0] = -5; /* singular */
    else
        info[14] = count;
}

void ma27cd_(Ints n, double *a, Ints la, int *iw, Ints liw, double *w, Ints maxfrt, double *right, int *iw1,
             Ints nsteps, Ints icntl, const double *cntl) {
    Solver *solver = active;
    (void)la, (void)liw, (void)w, (void)maxfrt, (void)iw1, (void)nsteps, (void)icntl, (void)cntl;
    if (solver && !solver->refused) {
        solver->solutions++;
        if (solve(solver, solver->instances[iw[0]], a, right)) return;
        solver->refused = REFUSED_RESIDUAL;
    }
    /* never a wrong step: IPOPT sees a residual as large as the right side, asks for another factor and gets none */
    memset(right, 0, sizeof(double) * *n);
}
