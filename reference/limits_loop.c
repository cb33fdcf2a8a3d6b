/* What a compiler makes of the engine's data layout without any engine: plain loops, compiled by reference/limits.py.

   A step reads rows `from` and writes rows `to`. Chunks own ranges of rows; pairs inside a chunk are listed once,
   pairs across chunks in both, so that no two threads write to one place.
   Signs: n points from a to b, forces are those on a: F = -normal n + shear. */

#include <math.h>
#include <stdint.h>
#include <omp.h>

/* 3D row: x y z radius | vx vy vz mass | wx wy wz material.  History of a pair: shear force x y z. */
enum { W3 = 12, W2 = 8 };

typedef struct { double kn, ks, friction, damping, dt, gx, gy, gz, tension, cohesion; } Parameters;

/* Cundall's local damping: the force is less by a share of itself where it speeds up, more where it slows down. */
static inline double damped(double force, double velocity, double damping)
{
    const double work = force * velocity;
    return force - (work > 0.0 ? damping : work < 0.0 ? -damping : 0.0) * force;
}

static void spheres_chunk(int64_t lo, int64_t hi, int64_t first, int64_t last, const uint32_t *restrict pa,
                          const uint32_t *restrict pb, uint8_t *restrict touching, double *restrict history,
                          int64_t stride, const double *restrict from, double *restrict to, double *restrict load,
                          const Parameters p)
{
    for (int64_t k = 0; k < 6 * (hi - lo); k++) load[k] = 0.0;
    for (int64_t c = first; c < last; c++) {
        const double *a = from + W3 * (int64_t)pa[c], *b = from + W3 * (int64_t)pb[c];
        const double dx = b[0] - a[0], dy = b[1] - a[1], dz = b[2] - a[2], reach = a[3] + b[3];
        const double squared = dx * dx + dy * dy + dz * dz;
        double *s = history + stride * c;
        if (squared >= reach * reach) {
            if (touching[c]) { touching[c] = 0; s[0] = s[1] = s[2] = 0.0; }
            continue;
        }
        touching[c] = 1;
        const double distance = sqrt(squared), inverse = 1.0 / distance;
        const double nx = dx * inverse, ny = dy * inverse, nz = dz * inverse;
        const double overlap = reach - distance, arm_a = a[3] - 0.5 * overlap, arm_b = b[3] - 0.5 * overlap;
        /* (arm_a w_a + arm_b w_b) x n */
        const double rx = arm_a * a[8] + arm_b * b[8], ry = arm_a * a[9] + arm_b * b[9],
                     rz = arm_a * a[10] + arm_b * b[10];
        const double ux = b[4] - a[4] - (ry * nz - rz * ny), uy = b[5] - a[5] - (rz * nx - rx * nz),
                     uz = b[6] - a[6] - (rx * ny - ry * nx);
        const double un = ux * nx + uy * ny + uz * nz;
        /* the old shear force turned into the new contact plane, then the spring */
        const double across = s[0] * nx + s[1] * ny + s[2] * nz, k = p.ks * p.dt;
        double sx = s[0] - across * nx + k * (ux - un * nx), sy = s[1] - across * ny + k * (uy - un * ny),
               sz = s[2] - across * nz + k * (uz - un * nz);
        const double normal = p.kn * overlap, limit = p.friction * normal, size = sx * sx + sy * sy + sz * sz;
        const double scale = size > limit * limit ? limit / sqrt(size) : 1.0;
        sx *= scale; sy *= scale; sz *= scale;
        s[0] = sx; s[1] = sy; s[2] = sz;
        const double fx = sx - normal * nx, fy = sy - normal * ny, fz = sz - normal * nz;
        const double tx = ny * sz - nz * sy, ty = nz * sx - nx * sz, tz = nx * sy - ny * sx;
        const int64_t i = (int64_t)pa[c] - lo, j = (int64_t)pb[c] - lo;
        if (i >= 0 && i < hi - lo) {
            double *l = load + 6 * i;
            l[0] += fx; l[1] += fy; l[2] += fz;
            l[3] += arm_a * tx; l[4] += arm_a * ty; l[5] += arm_a * tz;
        }
        if (j >= 0 && j < hi - lo) {
            double *l = load + 6 * j;
            l[0] -= fx; l[1] -= fy; l[2] -= fz;
            l[3] += arm_b * tx; l[4] += arm_b * ty; l[5] += arm_b * tz;
        }
    }
    for (int64_t i = lo; i < hi; i++) {
        const double *o = from + W3 * i, *l = load + 6 * (i - lo);
        double *t = to + W3 * i;
        const double mass = o[7], push = p.dt / mass, turn = p.dt / (0.4 * mass * o[3] * o[3]);
        t[4] = o[4] + push * damped(l[0] + mass * p.gx, o[4], p.damping);
        t[5] = o[5] + push * damped(l[1] + mass * p.gy, o[5], p.damping);
        t[6] = o[6] + push * damped(l[2] + mass * p.gz, o[6], p.damping);
        t[8] = o[8] + turn * damped(l[3], o[8], p.damping);
        t[9] = o[9] + turn * damped(l[4], o[9], p.damping);
        t[10] = o[10] + turn * damped(l[5], o[10], p.damping);
        t[0] = o[0] + p.dt * t[4]; t[1] = o[1] + p.dt * t[5]; t[2] = o[2] + p.dt * t[6];
        t[3] = o[3]; t[7] = mass; t[11] = o[11];
    }
}

/* 2D row: x y radius material | vx vy spin mass.  History of a pair: shear force, overlap at bonding.
   A bond carries tension up to `tension` and shear up to cohesion + friction * normal; what breaks is a contact. */
static void discs_chunk(int64_t lo, int64_t hi, int64_t first, int64_t last, const uint32_t *restrict pa,
                        const uint32_t *restrict pb, int32_t *restrict bond, uint8_t *restrict touching,
                        double *restrict history, int64_t stride, const double *restrict from,
                        double *restrict to, double *restrict load, const Parameters p)
{
    for (int64_t k = 0; k < 3 * (hi - lo); k++) load[k] = 0.0;
    for (int64_t c = first; c < last; c++) {
        const double *a = from + W2 * (int64_t)pa[c], *b = from + W2 * (int64_t)pb[c];
        const double dx = b[0] - a[0], dy = b[1] - a[1], reach = a[2] + b[2];
        const double squared = dx * dx + dy * dy;
        double *s = history + stride * c;
        const int bonded = bond[c] > 0;
        if (!bonded && squared >= reach * reach) {
            if (touching[c]) { touching[c] = 0; s[0] = 0.0; }
            continue;
        }
        touching[c] = 1;
        const double distance = sqrt(squared), inverse = 1.0 / distance, nx = dx * inverse, ny = dy * inverse;
        const double overlap = reach - distance, arm_a = a[2] - 0.5 * overlap, arm_b = b[2] - 0.5 * overlap;
        const double slip = (b[5] - a[5]) * nx - (b[4] - a[4]) * ny - arm_a * a[6] - arm_b * b[6];
        double normal = p.kn * (overlap - s[1]), shear = s[0] + p.ks * p.dt * slip;
        double limit = p.friction * normal;
        if (bonded) {
            limit += p.cohesion;
            if (normal < -p.tension || fabs(shear) > limit) {
                bond[c] = 0;
                normal = normal > 0.0 ? normal : 0.0;
                limit = p.friction * normal;
            }
        }
        shear = shear > limit ? limit : shear < -limit ? -limit : shear;
        s[0] = shear;
        const double fx = -normal * nx - shear * ny, fy = -normal * ny + shear * nx;
        const int64_t i = (int64_t)pa[c] - lo, j = (int64_t)pb[c] - lo;
        if (i >= 0 && i < hi - lo) {
            double *l = load + 3 * i;
            l[0] += fx; l[1] += fy; l[2] += arm_a * shear;
        }
        if (j >= 0 && j < hi - lo) {
            double *l = load + 3 * j;
            l[0] -= fx; l[1] -= fy; l[2] += arm_b * shear;
        }
    }
    for (int64_t i = lo; i < hi; i++) {
        const double *o = from + W2 * i, *l = load + 3 * (i - lo);
        double *t = to + W2 * i;
        const double mass = o[7], push = p.dt / mass, turn = p.dt / (0.5 * mass * o[2] * o[2]);
        t[4] = o[4] + push * damped(l[0] + mass * p.gx, o[4], p.damping);
        t[5] = o[5] + push * damped(l[1] + mass * p.gy, o[5], p.damping);
        t[6] = o[6] + turn * damped(l[2], o[6], p.damping);
        t[0] = o[0] + p.dt * t[4]; t[1] = o[1] + p.dt * t[5];
        t[2] = o[2]; t[3] = o[3]; t[7] = mass;
    }
}

/* `loads` holds 6 (3D) or 3 (2D) times `chunk` doubles for every thread. Returns the row set that is the newest. */
int spheres(int64_t n, int64_t chunk, int64_t steps, int current, double *rows, const int64_t *start,
            const uint32_t *pa, const uint32_t *pb, uint8_t *touching, double *history, int64_t stride,
            double *loads, const Parameters *given, int threads)
{
    const int64_t chunks = (n + chunk - 1) / chunk;
    const Parameters p = *given;
#pragma omp parallel num_threads(threads)
    for (int64_t step = 0; step < steps; step++) {
        const int side = (int)((current + step) & 1);
        const double *from = rows + side * n * W3;
        double *to = rows + (1 - side) * n * W3, *load = loads + 6 * chunk * omp_get_thread_num();
#pragma omp for schedule(static)
        for (int64_t c = 0; c < chunks; c++) {
            const int64_t lo = c * chunk, hi = lo + chunk < n ? lo + chunk : n;
            spheres_chunk(lo, hi, start[c], start[c + 1], pa, pb, touching, history, stride, from, to, load, p);
        }
    }
    return (int)((current + steps) & 1);
}

int discs(int64_t n, int64_t chunk, int64_t steps, int current, double *rows, const int64_t *start,
          const uint32_t *pa, const uint32_t *pb, int32_t *bond, uint8_t *touching, double *history,
          int64_t stride, double *loads, const Parameters *given, int threads)
{
    const int64_t chunks = (n + chunk - 1) / chunk;
    const Parameters p = *given;
#pragma omp parallel num_threads(threads)
    for (int64_t step = 0; step < steps; step++) {
        const int side = (int)((current + step) & 1);
        const double *from = rows + side * n * W2;
        double *to = rows + (1 - side) * n * W2, *load = loads + 3 * chunk * omp_get_thread_num();
#pragma omp for schedule(static)
        for (int64_t c = 0; c < chunks; c++) {
            const int64_t lo = c * chunk, hi = lo + chunk < n ? lo + chunk : n;
            discs_chunk(lo, hi, start[c], start[c + 1], pa, pb, bond, touching, history, stride, from, to, load, p);
        }
    }
    return (int)((current + steps) & 1);
}

/* Seconds of one a = b + s c over n doubles. */
double triad(int64_t n, double *restrict a, const double *restrict b, const double *restrict c, double s, int threads)
{
    const double begin = omp_get_wtime();
#pragma omp parallel for num_threads(threads) schedule(static)
    for (int64_t i = 0; i < n; i++) a[i] = b[i] + s * c[i];
    return omp_get_wtime() - begin;
}

/* Written by the threads that will read them, so that memory lies near them. */
void triad_fill(int64_t n, double *a, double *b, double *c, int threads)
{
#pragma omp parallel for num_threads(threads) schedule(static)
    for (int64_t i = 0; i < n; i++) { a[i] = 0.0; b[i] = 1.0; c[i] = 2.0; }
}
