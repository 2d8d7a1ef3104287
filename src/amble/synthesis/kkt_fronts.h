/* KKT systems whose equality rows are regularised, [H J'; J -D], as those of IPOPT's restoration are.
 *
 * Rows with an entry of D of their own no longer determine unknowns, so neither can be eliminated by the other alone.
 * Both are, together: first the unknowns, rows and inequalities of a node, then the states and defect rows of an
 * interval, last the end, each with the pivots of Bunch and Kaufman inside a dense front. Pivots never leave their
 * front; where that loses digits the residual shows it, and the solution is refused like any other. The inertia is the
 * sum over the fronts (Haynsworth, 1968).
 *
 * Slacks go first: with z = y_d + r_s
 *
 *     Sigma_s s = z,   J_d x - (1 / Sigma_s + D_d) z = r_d - D_d r_s,   H x + J_c' y_c + J_d' z = r_x + J_d' r_s.
 *
 * Part of structured_kkt.c.
 */

typedef struct {
    int pivots, size, parent;     /* the pivots come first; parent: front of the earliest unknown of the border */
    int first, last;              /* its entries */
    int *index, *place_in_parent; /* unknowns; of the border */
    int *swaps;
    double *factor, *border; /* (pivots, pivots); (size - pivots, pivots) */
    double *left;            /* what it adds to its parent, until that has taken it */
} Front;

struct Fronts {
    int count, largest, most_pivots;
    Front *front;
    int *source, *place; /* triplets by front, and where they go in it */
    double *work, *right, *vector, *rows;
};

/* Order of elimination: nodes from the end of a domain to its entry, each interval after its later nodes. */
static int number_fronts(const Plan *p, int *front, int *of_row) {
    int nx = p->variables, count = 0, node = 0;
    for (int i = 0; i < nx + p->inequalities; i++) front[i] = -1;
    for (int i = 0; i < p->equalities + p->inequalities; i++) of_row[i] = -1;
    for (int k = 0; k < p->domains; k++) {
        const Domain *d = p->domain + k;
        int unknowns = node_unknowns(d), nd = defects(d);
        for (int i = d->nodes - 1; i >= 0; i--) {
            Ints at = d->variable + i * unknowns;
            for (int j = d->ns; j < unknowns; j++) front[at[j]] = count;
            for (int j = 0; j < d->ne; j++) of_row[d->explicit_row[i * d->ne + j]] = count;
            for (int j = 0; j < d->ny; j++) of_row[d->implicit_row[i * d->ny + j]] = count;
            for (int r = p->node_inequality[node + i]; r < p->node_inequality[node + i + 1]; r++)
                of_row[p->equalities + p->inequality_row[r]] = count;
            count++;
            if (i == 0 || (i - 1) % d->stages) continue;
            int interval = (i - 1) / d->stages;
            for (int s = 0; s < d->stages; s++)
                for (int j = 0; j < d->ns; j++) front[d->variable[(i + s) * unknowns + j]] = count;
            for (int j = 0; j < nd; j++) of_row[d->defect_row[interval * nd + j]] = count;
            count++;
        }
        node += d->nodes;
    }
    for (int i = 0; i < nx; i++)
        if (front[i] < 0) front[i] = count;
    for (int i = 0; i < p->equalities + p->inequalities; i++)
        if (of_row[i] < 0) of_row[i] = count;
    return count + 1;
}

/* Entries by the front that takes them; what has a slack has none. */
static int sort_entries(const Instance *I, struct Fronts *F, const int *front, int *start) {
    int count = 0;
    for (int t = 0; t < I->nonzeros; t++) {
        int a = front[I->row[t]], b = front[I->column[t]];
        if (a >= 0 && b >= 0) start[(a < b ? a : b) + 2]++, count++;
    }
    for (int g = 1; g <= F->count; g++) start[g + 1] += start[g];
    if (!F->source) return count;
    for (int t = 0; t < I->nonzeros; t++) {
        int a = front[I->row[t]], b = front[I->column[t]];
        if (a >= 0 && b >= 0) F->source[start[(a < b ? a : b) + 1]++] = t;
    }
    return count;
}

/* Unknowns of a front: its own, then those that its entries and its children read besides. */
static void fill_front(Instance *I, struct Fronts *F, int g, const int *front, int *local, int *list, int *failed) {
    Front *f = F->front + g;
    int size = 0;
    for (int u = 0; u < I->size; u++)
        if (front[u] == g) local[u] = size, list[size++] = u;
    f->pivots = size;
    for (int e = f->first; e < f->last; e++) {
        int ends[2] = {I->row[F->source[e]], I->column[F->source[e]]};
        for (int k = 0; k < 2; k++)
            if (local[ends[k]] < 0) local[ends[k]] = size, list[size++] = ends[k];
    }
    for (int c = 0; c < g; c++) {
        const Front *child = F->front + c;
        if (child->parent != g) continue;
        for (int k = child->pivots; k < child->size; k++)
            if (local[child->index[k]] < 0) local[child->index[k]] = size, list[size++] = child->index[k];
        for (int k = child->pivots; k < child->size; k++)
            child->place_in_parent[k - child->pivots] = local[child->index[k]];
    }
    f->size = size;
    f->parent = F->count;
    for (int k = f->pivots; k < size; k++)
        if (front[list[k]] < f->parent) f->parent = front[list[k]];
    for (int e = f->first; e < f->last; e++) {
        int a = local[I->row[F->source[e]]], b = local[I->column[F->source[e]]];
        F->place[e] = (a < b ? a : b) * size + (a < b ? b : a);
    }
    f->index = INTEGERS(size);
    f->place_in_parent = INTEGERS(size);
    f->swaps = INTEGERS(f->pivots);
    f->factor = DOUBLES((size_t)f->pivots * f->pivots);
    f->border = DOUBLES((size_t)f->pivots * (size - f->pivots));
    if (!*failed) memcpy(f->index, list, sizeof(int) * size);
    for (int k = 0; k < size; k++) local[list[k]] = -1;
    if (size > F->largest) F->largest = size;
    if (f->pivots > F->most_pivots) F->most_pivots = f->pivots;
}

/* Fronts of an instance, made when the first regularised system arrives. */
static struct Fronts *make_fronts(const Plan *p, Instance *I, int *failed) {
    int nx = p->variables, ni = p->inequalities, n = I->size;
    struct Fronts *F = take(I, 1, sizeof(struct Fronts), failed);
    int *front = INTEGERS(n), *local = INTEGERS(n), *list = INTEGERS(n);
    if (*failed) return NULL;
    F->count = number_fronts(p, front, front + nx + ni);
    int *start = INTEGERS(F->count + 2);
    F->front = take(I, F->count, sizeof(Front), failed);
    if (*failed) return NULL;
    int entries = sort_entries(I, F, front, start);
    memset(start, 0, sizeof(int) * (F->count + 2));
    F->source = INTEGERS(entries);
    F->place = INTEGERS(entries);
    if (*failed) return NULL;
    sort_entries(I, F, front, start);
    for (int u = 0; u < n; u++) local[u] = -1;
    for (int g = 0; g < F->count && !*failed; g++) {
        F->front[g].first = g ? start[g] : 0; /* sorting has moved every start to the next one */
        F->front[g].last = start[g + 1];
        fill_front(I, F, g, front, local, list, failed);
    }
    size_t border = 0;
    for (int g = 0; g < F->count; g++)
        border = larger(border, (size_t)F->front[g].pivots * (F->front[g].size - F->front[g].pivots));
    F->work = DOUBLES((size_t)F->largest * F->largest + border + 64 * ((size_t)F->most_pivots + 1));
    F->right = DOUBLES(n);
    F->vector = DOUBLES(F->largest);
    F->rows = DOUBLES(2 * (size_t)ni);
    return *failed ? NULL : F;
}

static void drop_left(struct Fronts *F) {
    for (int g = 0; F && g < F->count; g++) {
        free(F->front[g].left);
        F->front[g].left = NULL;
    }
}

/* Sum a front: its entries, 1 / Sigma_s of its inequalities, and what its children leave. */
static void assemble_front(const Plan *p, Instance *I, int g, const double *a, double *whole) {
    struct Fronts *F = I->fronts;
    Front *f = F->front + g;
    int first = p->variables + p->inequalities + p->equalities, n = f->size;
    memset(whole, 0, sizeof(double) * n * n);
    for (int e = f->first; e < f->last; e++) {
        int d = I->row[F->source[e]] - first;
        if (d < 0 || I->weight[d] > 0.0) whole[F->place[e]] += a[F->source[e]];
    }
    for (int k = 0; k < f->pivots; k++) {
        int d = f->index[k] - first;
        if (d >= 0) whole[(size_t)k * (n + 1)] += I->weight[d] > 0.0 ? -1.0 / I->weight[d] : -1.0;
    }
    for (int c = 0; c < g; c++) {
        Front *child = F->front + c;
        if (child->parent != g) continue;
        int border = child->size - child->pivots;
        for (int j = 0; j < border; j++)
            for (int i = j; i < border; i++) {
                int r = child->place_in_parent[i], s = child->place_in_parent[j];
                whole[(size_t)(r < s ? r : s) * n + (r < s ? s : r)] += child->left[(size_t)j * border + i];
            }
        free(child->left);
        child->left = NULL;
    }
}

/* Returns the number of negative eigenvalues of the pivots; -1 where they are singular, -1 - reason where refused. */
static int factor_front(const Blas *blas, struct Fronts *F, Front *f, double *whole) {
    int n = f->size, np = f->pivots, nb = n - np, info = 0, lwork = 64 * (F->most_pivots + 1);
    double *X = whole + (size_t)F->largest * F->largest, *lapack = F->work;
    lapack = X + (size_t)np * nb;
    for (int j = 0; j < np; j++) {
        memcpy(f->factor + (size_t)j * np + j, whole + (size_t)j * n + j, sizeof(double) * (np - j));
        memcpy(f->border + (size_t)j * nb, whole + (size_t)j * n + np, sizeof(double) * nb);
    }
    blas->sytrf("L", &np, f->factor, &np, f->swaps, lapack, &lwork, &info);
    if (info > 0) return -1;
    int count = negative(f->factor, f->swaps, np);
    if (count < 0) return count == -2 ? -1 - REFUSED_PIVOT : -1;
    if (!nb) return count;
    f->left = malloc(sizeof(double) * nb * nb);
    if (!f->left) return -1 - REFUSED_MEMORY;
    for (int j = 0; j < nb; j++) {
        memcpy(f->left + (size_t)j * nb, whole + (size_t)(np + j) * n + np, sizeof(double) * nb);
        for (int i = 0; i < np; i++) X[(size_t)j * np + i] = f->border[(size_t)i * nb + j];
    }
    blas->sytrs("L", &np, &nb, f->factor, &np, f->swaps, X, &np, &info);
    blas->gemm("N", "N", &nb, &nb, &np, &MINUS, f->border, &nb, X, &np, &ONE, f->left, &nb);
    return count;
}

static int factor_fronts(Solver *solver, Instance *I, const double *a) {
    int problem = 0, *failed = &problem, total = 0, count = 0;
    if (!I->fronts) I->fronts = make_fronts(&solver->plan, I, failed);
    if (!I->fronts) return -1 - REFUSED_MEMORY;
    for (int g = 0; g < I->fronts->count && count >= 0; g++) {
        assemble_front(&solver->plan, I, g, a, I->fronts->work);
        count = factor_front(&solver->blas, I->fronts, I->fronts->front + g, I->fronts->work);
        total += count;
    }
    drop_left(I->fronts);
    return count < 0 ? count : total;
}

/* Solve by the fronts: b, in their unknowns, is replaced. */
static void sweep_fronts(const Blas *blas, struct Fronts *F, double *b) {
    int info;
    for (int g = 0; g < F->count; g++) {
        const Front *f = F->front + g;
        int np = f->pivots, nb = f->size - np;
        if (!nb || !np) continue;
        for (int k = 0; k < np; k++) F->vector[k] = b[f->index[k]];
        blas->sytrs("L", &np, &STEP, f->factor, &np, f->swaps, F->vector, &np, &info);
        blas->gemv("N", &nb, &np, &MINUS, f->border, &nb, F->vector, &STEP, &ZERO, F->vector + np, &STEP);
        for (int k = 0; k < nb; k++) b[f->index[np + k]] += F->vector[np + k];
    }
    for (int g = F->count - 1; g >= 0; g--) {
        const Front *f = F->front + g;
        int np = f->pivots, nb = f->size - np;
        if (!np) continue;
        for (int k = 0; k < f->size; k++) F->vector[k] = b[f->index[k]];
        if (nb)
            blas->gemv("T", &nb, &np, &MINUS, f->border, &nb, F->vector + np, &STEP, &ONE, F->vector, &STEP);
        blas->sytrs("L", &np, &STEP, f->factor, &np, f->swaps, F->vector, &np, &info);
        for (int k = 0; k < np; k++) b[f->index[k]] = F->vector[k];
    }
}

/* Solve once: out of r, in the order of the rows of the whole matrix. */
static void solve_by_fronts(Solver *solver, Instance *I, const double *a, const double *r, double *out) {
    const Plan *p = &solver->plan;
    struct Fronts *F = I->fronts;
    int nx = p->variables, ni = p->inequalities, first = nx + ni + p->equalities, end = I->blocks - 4;
    const double *rs = r + nx, *rd = r + first;
    double *regular = F->rows, *z = out + first;
    memset(regular, 0, sizeof(double) * ni);
    for (int t = I->start[end + ZEROS]; t < I->start[end + ZEROS + 1]; t++) {
        int d = I->row[I->source[t]] - first;
        if (d >= 0) regular[d] -= a[I->source[t]];
    }
    memcpy(out, r, sizeof(double) * I->size);
    for (int i = 0; i < ni; i++) {
        subtract_row(I, a, -1 - i, -rs[i], out);
        z[i] = I->weight[i] > 0.0 ? rd[i] - regular[i] * rs[i] : 0.0;
    }
    sweep_fronts(&solver->blas, F, out);
    for (int i = 0; i < ni; i++) {
        double along = row_product(I, a, -1 - i, out) - rd[i];
        if (I->weight[i] > 1.0) { /* the smaller of two errors: s = z / Sigma_s, or s from its own row */
            out[nx + i] = z[i] / I->weight[i];
            z[i] -= rs[i];
        } else {
            out[nx + i] = (along + regular[i] * rs[i]) / (1.0 + regular[i] * I->weight[i]);
            z[i] = I->weight[i] * out[nx + i] - rs[i];
        }
    }
}
