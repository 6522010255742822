/* The least program that solves a linear elastic body of tetrahedra with CHOLMOD: what mfec is
   measured against where there is no contact. Reads problem.bin, written by bare.py:
   int64 nodes, elements, wanted dof; double lambda, mu; double x[nodes][3];
   int64 corner[elements][4] (from 0); int8 held[3*nodes]; double given[3*nodes], force[3*nodes].
   Prints the wanted displacement, operations and seconds of the factorisation, numbers in
   the factor, seconds of the solve. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <cholmod.h>

static void take(void *to, size_t size, size_t count, FILE *file)
{
  if (fread(to, size, count, file) != count) { fprintf(stderr, "problem.bin is short\n"); exit(3); }
}

/* Gradients of the four shape functions; returns the volume. */
static double gradients(const double *x, const int64_t *c, double g[4][3])
{
  double e[3][3], n[3][3], d = 0.0;
  for (int k = 0; k < 3; k++)
    for (int i = 0; i < 3; i++) e[k][i] = x[3*c[k + 1] + i] - x[3*c[0] + i];
  for (int k = 0; k < 3; k++)
    for (int i = 0; i < 3; i++) {
      const double *a = e[(k + 1)%3], *b = e[(k + 2)%3];
      n[k][i] = a[(i + 1)%3]*b[(i + 2)%3] - a[(i + 2)%3]*b[(i + 1)%3];
    }
  for (int i = 0; i < 3; i++) d += e[0][i]*n[0][i];
  for (int i = 0; i < 3; i++) {
    g[0][i] = 0.0;
    for (int k = 0; k < 3; k++) { g[k + 1][i] = n[k][i]/d; g[0][i] -= n[k][i]/d; }
  }
  return d/6.0;
}

int main(void)
{
  int64_t head[3];
  double lame[2], g[4][3];
  FILE *file = fopen("problem.bin", "rb");
  if (!file) return 1;
  take(head, sizeof *head, 3, file);
  take(lame, sizeof *lame, 2, file);
  const int64_t nodes = head[0], elements = head[1], dofs = 3*nodes;
  double *x = malloc(8*dofs), *u = malloc(8*dofs), *f = malloc(8*dofs);
  int64_t *corner = malloc(32*elements), *row = malloc(8*dofs);
  char *held = malloc(dofs);
  take(x, 8, dofs, file);
  take(corner, 8, 4*elements, file);
  take(held, 1, dofs, file);
  take(u, 8, dofs, file);
  take(f, 8, dofs, file);
  fclose(file);
  int64_t free_dofs = 0;
  for (int64_t i = 0; i < dofs; i++) row[i] = held[i] ? -1 : free_dofs++;

  cholmod_common common;
  cholmod_l_start(&common);
  common.supernodal = CHOLMOD_SUPERNODAL;
  common.nmethods = 1;
  common.method[0].ordering = CHOLMOD_METIS;
  cholmod_triplet *t = cholmod_l_allocate_triplet(free_dofs, free_dofs, 78*elements, -1,
                                                  CHOLMOD_REAL, &common);
  SuiteSparse_long *ti = t->i, *tj = t->j;
  double *tx = t->x;
  for (int64_t e = 0; e < elements; e++) {
    const int64_t *c = corner + 4*e;
    const double volume = gradients(x, c, g);
    for (int a = 0; a < 4; a++)
      for (int b = 0; b < 4; b++) {
        double dot = 0.0;
        for (int i = 0; i < 3; i++) dot += g[a][i]*g[b][i];
        for (int i = 0; i < 3; i++)
          for (int j = 0; j < 3; j++) {
            const double k = volume*(lame[0]*g[a][i]*g[b][j] + lame[1]*g[a][j]*g[b][i] +
                                     (i == j ? lame[1]*dot : 0.0));
            const int64_t p = row[3*c[a] + i], q = row[3*c[b] + j];
            if (p < 0) continue;
            if (q < 0) f[3*c[a] + i] -= k*u[3*c[b] + j];
            else if (p >= q) { ti[t->nnz] = p; tj[t->nnz] = q; tx[t->nnz++] = k; }
          }
      }
  }
  cholmod_sparse *matrix = cholmod_l_triplet_to_sparse(t, t->nnz, &common);
  cholmod_l_free_triplet(&t, &common);
  cholmod_dense *right = cholmod_l_zeros(free_dofs, 1, CHOLMOD_REAL, &common);
  for (int64_t i = 0; i < dofs; i++)
    if (row[i] >= 0) ((double *)right->x)[row[i]] = f[i];
  cholmod_factor *factor = cholmod_l_analyze(matrix, &common);
  const clock_t begin = clock();
  cholmod_l_factorize(matrix, factor, &common);
  const double seconds = (double)(clock() - begin)/CLOCKS_PER_SEC;
  if (common.status != CHOLMOD_OK) return 2;
  const clock_t middle = clock();
  cholmod_dense *found = cholmod_l_solve(CHOLMOD_A, factor, right, &common);
  const double solve = (double)(clock() - middle)/CLOCKS_PER_SEC;
  printf("%.15e %.6e %.6e %.6e %.6e\n", ((double *)found->x)[row[head[2]]], common.fl, seconds,
         common.lnz, solve);
  return 0;
}
