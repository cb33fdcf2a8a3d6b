"""YADE and LIGGGHTS written down once more, plainly, for a handful of spheres: from their documents, not from geodem.

Nothing here shares a line with geodem's laws or kernels. It stands between geodem and the other codes: where all three
agree, a formula that is wrong would have to be wrong twice in the same way; where a code is not installed, geodem is
still held to something outside it. Loops over pairs in Python; spheres in space and planes along the axes only.
"""

from __future__ import annotations

import math

import numpy as np

from reference.posed import Posed, Trajectory


def harmonic(a, b):
    return 2.0 * a * b / (a + b)


class Stepper:
    """Spheres of a posed scene; forces at x with the velocities half a step before, then motion."""

    def __init__(self, posed: Posed):
        a = self.a = posed.assembly
        self.dt, self.damping, self.convention = posed.time_step, posed.local_damping, posed.convention
        self.x, self.v, self.w = (
            np.array(part, dtype=float) for part in (a.positions, a.velocities, a.spins)
        )
        self.q = np.tile([1.0, 0.0, 0.0, 0.0], (a.particles, 1))
        self.r, self.m, self.inertia = a.radii, a.mass, a.inertia
        self.shear: dict = {}  # force on the second (YADE), or displacement of the first (LIGGGHTS)
        self.normal: dict = {}
        self.bonds = {tuple(map(int, pair)): {"initial": None} for pair in a.bonds}
        self.unloaded: dict = {}
        self.broken: list = []
        self.step = 0
        count = len(a.material_names)
        # the geodem tables hold each material's own numbers on their diagonal
        self.own = [self._named(a.contact_law, a.contact_table[k * count + k]) for k in range(count)]
        self.bond_own = (
            [self._named(a.bond_law, a.bond_table[k * count + k]) for k in range(count)] if a.bond_law else []
        )

    @staticmethod
    def _named(law, row):
        from geodem.laws import BOND_LAWS, CONTACT_LAWS

        fields = {**CONTACT_LAWS, **BOND_LAWS}[law].PARAMETERS._fields
        return dict(zip(fields, map(float, row), strict=True))

    # ------------------------------------------------------------------ motion

    def advance(self):
        self.f, self.t = self.a.applied[:, :3].copy(), self.a.applied[:, 3:].copy()
        self.on_walls = np.zeros((len(self.a.walls), 3))
        self.force_pairs()
        if self.convention == "liggghts":
            self.push_liggghts()
        else:
            self.push_yade()
        self.step += 1

    def force_pairs(self):
        n = len(self.r)
        law = self.liggghts_pair if self.convention == "liggghts" else self.yade_pair
        for i in range(n):
            for j in range(i + 1, n):
                law(i, j)
        for k, wall in enumerate(self.a.walls):
            for p, (point, normal) in enumerate(wall.planes):
                place = point + wall.velocity * (self.step * self.dt)
                for i in range(n):
                    before = self.f[i].copy()
                    law(i, ("wall", k, p, place, normal, wall))
                    self.on_walls[k] -= self.f[i] - before

    def push_yade(self):
        dt, a = self.dt, self.a
        acceleration = self.f / self.m[:, None] + a.gravity
        turning = self.t / self.inertia[:, None]
        for rate, speed, held in ((acceleration, self.v, a.held[:, :3]), (turning, self.w, a.held[:, 3:])):
            rate *= 1.0 - self.damping * np.sign(rate * (speed + 0.5 * dt * rate))
            speed += np.where(held, 0.0, rate * dt)
        self.x += self.v * dt
        for i, w in enumerate(self.w):
            size = np.linalg.norm(w)
            if size > 0.0:
                half = 0.5 * size * dt
                self.q[i] = product((math.cos(half), *(math.sin(half) / size * w)), self.q[i])
                self.q[i] /= np.linalg.norm(self.q[i])

    def push_liggghts(self):
        # the first push is half a step: the velocities given are those of the positions
        share = 0.5 if self.step == 0 else 1.0
        held = self.a.held
        self.f += self.m[:, None] * self.a.gravity
        self.v += np.where(held[:, :3], 0.0, share * self.dt * self.f / self.m[:, None])
        self.w += np.where(held[:, 3:], 0.0, share * self.dt * self.t / self.inertia[:, None])
        self.x += self.v * self.dt

    # ------------------------------------------------------------------ YADE

    def yade_pair(self, i, j):
        dt, wall = self.dt, isinstance(j, tuple)
        key = (i, *j[:3]) if wall else (i, j)
        r1 = self.r[i]
        one = self.own[self.a.material[i]]
        if wall:
            _, _, _, point, normal, body = j
            # from the sphere to the wall
            n = -np.asarray(normal, dtype=float)
            gap = float((self.x[i] - point) @ normal)
            r2, distance = r1, r1 + gap
            v2, w2 = np.asarray(body.velocity, dtype=float), np.zeros(3)
            made = body.contact[self.a.material_names[self.a.material[i]]]
            other = {
                "young_modulus": made.other_young_modulus, "stiffness_ratio": made.other_stiffness_ratio,
                "friction_coefficient": made.friction_coefficient,
            }  # fmt: skip
        else:
            apart = self.x[j] - self.x[i]
            distance = math.sqrt(apart @ apart)
            n, r2 = apart / distance, self.r[j]
            v2, w2, other = self.v[j], self.w[j], self.own[self.a.material[j]]
        overlap = r1 + r2 - distance
        bond = self.bonds.get(key)
        intact = bond is not None and "broken" not in bond
        known = key in self.shear
        if bond is not None and bond["initial"] is None:
            bond["initial"] = overlap if self.a.bond_law == "jointed_cohesive" else 0.0
            bond["q"] = self.q[i].copy(), self.q[j].copy()
            self.shear[key], self.normal[key], known = np.zeros(3), n, True
        if not known:
            if overlap < 0.0:
                return
            self.shear[key], self.normal[key] = np.zeros(3), n
        e1, e2 = one["young_modulus"], other["young_modulus"]
        kn = harmonic(e1 * r1, e2 * r2)
        ks = harmonic(e1 * one["stiffness_ratio"] * r1, e2 * other["stiffness_ratio"] * r2)
        mu = math.tan(min(math.atan(one["friction_coefficient"]), math.atan(other["friction_coefficient"])))
        w1 = self.w[i]
        if known:
            old, s = self.normal[key], self.shear[key]
            s = s - np.cross(s, np.cross(old, n))
            s = s - np.cross(s, 0.5 * dt * (old @ (w1 + w2)) * old)
        else:
            s = self.shear[key]
        un = overlap - (bond["initial"] if bond else 0.0)
        if self.convention == "yade":
            relative = (v2 - self.v[i]) * (r1 + r2) / (r1 + r2 - overlap)
            relative = relative - np.cross(w2, r2 * n) - np.cross(w1, r1 * n)
        else:
            arm1, arm2 = (r1 - 0.5 * overlap) * n, -(r2 - 0.5 * overlap) * n
            relative = v2 + np.cross(w2, arm2) - self.v[i] - np.cross(w1, arm1)
        s = s - ks * (relative - (relative @ n) * n) * dt
        fn, moment = kn * un, np.zeros(3)
        size, gone = math.sqrt(s @ s), False
        if not intact:
            if un < 0.0:
                gone = True
            elif size > mu * abs(fn):
                s = s * (mu * abs(fn) / size) if size > 0.0 else s
        elif self.a.bond_law == "cohesive_moments":
            pulled, sheared = self.strength(i, j, "normal_cohesion"), self.strength(i, j, "shear_cohesion")
            moment = self.moments(i, j, bond, n, ks)
            limit = max(0.0, sheared + mu * fn)
            if fn < 0.0 and -fn > pulled:
                self.break_bond(key)
                gone = True
            elif size > limit:
                self.break_bond(key)
                s = s * (max(0.0, mu * fn) / size)
                fn, moment = max(fn, 0.0), np.zeros(3)
        else:
            pulled = math.pi * self.strength(i, j, "tensile_strength")
            sheared = math.pi * self.strength(i, j, "cohesion")
            limit = sheared + mu * fn
            if un < 0.0 and -un > pulled / kn:
                self.break_bond(key)
                gone = True
            elif size > limit:
                self.break_bond(key)
                s = s * (limit / size)
        if gone:
            del self.shear[key], self.normal[key]
            return
        self.shear[key], self.normal[key] = s, n
        f = fn * n + s
        self.f[i] -= f
        self.t[i] += np.cross((r1 - 0.5 * overlap) * n, -f) + moment
        if not wall:
            self.f[j] += f
            self.t[j] += np.cross(-(r2 - 0.5 * overlap) * n, f) - moment

    def strength(self, i, j, name):
        """Of the weaker material, times the square of the smaller radius."""
        rows = (self.bond_own[self.a.material[k]][name] for k in (i, j))
        return min(rows) * min(self.r[i], self.r[j]) ** 2

    def moments(self, i, j, bond, n, ks):
        """On the first: stiffness times the relative rotation since bonding, as one rotation vector."""
        rows = [self.bond_own[self.a.material[k]] for k in (i, j)]
        size = self.r[i] * self.r[j] * ks
        bend = size * harmonic(rows[0]["bending_factor"], rows[1]["bending_factor"])
        twist = size * harmonic(rows[0]["twisting_factor"], rows[1]["twisting_factor"])
        first = product(self.q[i], inverse(bond["q"][0]))
        second = product(self.q[j], inverse(bond["q"][1]))
        w, *vector = product(second, inverse(first))
        length = math.sqrt(sum(c * c for c in vector))
        angle = 2.0 * math.atan2(length, w)
        angle -= 2.0 * math.pi if angle > math.pi else 0.0
        theta = np.array(vector) * (angle / length) if length > 0.0 else np.zeros(3)
        about = theta @ n
        return twist * about * n + bend * (theta - about * n)

    def break_bond(self, key):
        self.bonds[key]["broken"] = True
        self.broken.append((*key, self.step + 1))

    # ------------------------------------------------------------------ LIGGGHTS

    def liggghts_pair(self, i, j):
        dt, wall = self.dt, isinstance(j, tuple)
        key = (i, *j[:3]) if wall else (i, j)
        r1 = self.r[i]
        if wall:
            _, _, _, point, normal, body = j
            en = np.asarray(normal, dtype=float)  # from the wall to the sphere
            distance = float((self.x[i] - point) @ en)
            overlap, radius, mass = r1 - distance, r1, self.m[i]
            v2, w2, c2 = np.zeros(3), np.zeros(3), 0.0
            p = body.contact[self.a.material_names[self.a.material[i]]]._asdict()
        else:
            apart = self.x[i] - self.x[j]
            distance = math.sqrt(apart @ apart)
            r2, en = self.r[j], apart / distance
            overlap, radius = r1 + r2 - distance, r1 * r2 / (r1 + r2)
            mass = self.m[i] * self.m[j] / (self.m[i] + self.m[j])
            v2, w2, c2 = self.v[j], self.w[j], r2 - 0.5 * overlap
            p = self.pair_numbers(i, j)
        if overlap <= 0.0:
            self.shear.pop(key, None)
            return
        c1 = r1 - 0.5 * overlap
        v = self.v[i] - v2
        vn = v @ en
        u = v - vn * en - np.cross(c1 * self.w[i] + c2 * w2, en)
        kn, kt, gn, gt = self.coefficients(p, radius, mass, overlap, wall, i, j)
        s = self.shear.get(key, np.zeros(3))
        if self.step > 0:
            s = s + u * dt
        s = s - (s @ en) * en
        self.shear[key] = s
        fn = kn * overlap - gn * vn
        size, limit = kt * math.sqrt(s @ s), p["friction_coefficient"] * abs(fn)
        if size > limit:
            ft = -kt * s * (limit / size)
            self.shear[key] = -ft / kt
        else:
            ft = -kt * s - gt * u
        f = fn * en + ft
        self.f[i] += f
        self.t[i] -= c1 * np.cross(en, ft)
        if not wall:
            self.f[j] -= f
            self.t[j] -= c2 * np.cross(en, ft)

    def pair_numbers(self, i, j):
        """Of friction, restitution, stiffnesses and dampings by pair; moduli are those of both materials."""
        count = len(self.own)
        row = self.a.contact_table[int(self.a.material[i]) * count + int(self.a.material[j])]
        return self._named(self.a.contact_law, row)

    def coefficients(self, p, radius, mass, overlap, wall, i, j):
        if self.a.contact_law == "hooke_stiffness":
            return (
                p["normal_stiffness"], p["shear_stiffness"], mass * p["normal_damping"], mass * p["shear_damping"],
            )  # fmt: skip
        sides = [self.own[self.a.material[i]]] + ([] if wall else [self.own[self.a.material[j]]])
        young = 1.0 / sum((1.0 - s["poisson_ratio"] ** 2) / s["young_modulus"] for s in sides)
        rigid = 1.0 / sum(
            2.0 * (2.0 - s["poisson_ratio"]) * (1.0 + s["poisson_ratio"]) / s["young_modulus"] for s in sides
        )
        log = math.log(p["restitution"])
        if self.a.contact_law == "hooke":
            root = math.sqrt(radius)
            pace = p["characteristic_velocity"]
            kn = 16 / 15 * root * young * (15.0 * mass * pace**2 / (16.0 * root * young)) ** 0.2
            gamma = math.sqrt(4.0 * mass * kn * log**2 / (log**2 + math.pi**2))
            return kn, kn, gamma, gamma
        q = math.sqrt(radius * overlap)
        beta = log / math.sqrt(log**2 + math.pi**2)
        kt = 8.0 * rigid * q
        share = -2.0 * math.sqrt(5 / 6) * beta
        return (
            4 / 3 * young * q, kt, share * math.sqrt(2.0 * young * q * mass), share * math.sqrt(kt * mass),
        )  # fmt: skip


def product(p, q):
    a, b, c, d = p
    e, f, g, h = q
    return np.array(
        [
            a * e - b * f - c * g - d * h,
            a * f + b * e + c * h - d * g,
            a * g - b * h + c * e + d * f,
            a * h + b * g - c * f + d * e,
        ]
    )


def inverse(q):
    return np.array([q[0], -q[1], -q[2], -q[3]])


def run(posed: Posed) -> Trajectory:
    """All steps of a posed scene; forces between pairs are not told."""
    stepper = Stepper(posed)
    frames = []
    for step in range(1, posed.steps + 1):
        stepper.advance()
        if step in posed.frames:
            weight = posed.assembly.mass[:, None] * posed.assembly.gravity
            force = stepper.f if posed.convention == "liggghts" else stepper.f + weight
            kept = (stepper.x, stepper.v, stepper.w, force, stepper.t, stepper.on_walls)
            frames.append([part.copy() for part in kept])
    parts = [np.array(part) for part in zip(*frames, strict=True)]
    return Trajectory(
        "plain", "-", "as documented", np.array(posed.frames), *parts[:5], wall_forces=parts[5],
        broken=tuple(stepper.broken),
    )  # fmt: skip
