"""The motion of a small random network in 40 digits: what plain_reference_test.cpp holds every build to.

    plain_reference.py        prints the rows of kExpected

The network, drawn with SplitMix64 (seed 42) as the test draws it: 80 points in the unit cube; springs between point i and
points i + 1, i + 2, i + 7 and i + 31 (where there are so many); stiffness 5 to 15 N/m, rest length 0.8 to 1.2 of the
length at the start, damping 0.02 s x stiffness; mass 0.1 to 0.2 kg; environment damping 0.05 / s x mass; velocities of up to
0.5 m/s along each axis. Numbers are drawn as doubles and taken exactly. 500 steps of 2 ms, symplectic Euler.
"""

from decimal import Decimal, getcontext

POINTS, STEPS, SHOWN = 80, 500, (0, 17, 41, 79)
MASK = (1 << 64) - 1
getcontext().prec = 40


class SplitMix64:
    def __init__(self, seed):
        self.state = seed

    def uniform(self):
        self.state = (self.state + 0x9E3779B97F4A7C15) & MASK
        z = self.state
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & MASK
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & MASK
        return ((z ^ (z >> 31)) >> 11) * 2.0**-53


def draw():
    random = SplitMix64(42)
    points = [[random.uniform() for _ in range(3)] for _ in range(POINTS)]
    springs = []
    for i in range(POINTS):
        for j in (i + 1, i + 2, i + 7, i + 31):
            if j < POINTS:
                # Each figure is one rounded double operation after another, as in the test.
                stiffness = 5.0 + 10.0 * random.uniform()
                share = 0.8 + 0.4 * random.uniform()
                springs.append((i, j, stiffness, share, 0.02 * stiffness))
    masses = [0.1 + 0.1 * random.uniform() for _ in range(POINTS)]
    drags = [0.05 * mass for mass in masses]
    velocities = [[random.uniform() - 0.5 for _ in range(3)] for _ in range(POINTS)]
    return points, springs, masses, drags, velocities


def main():
    points, springs, masses, drags, velocities = draw()
    x = [[Decimal(c) for c in point] for point in points]
    v = [[Decimal(c) for c in velocity] for velocity in velocities]
    mass, drag = [Decimal(m) for m in masses], [Decimal(d) for d in drags]
    h = Decimal(0.002)
    start = [list(point) for point in x]

    def difference(a, b):
        return [p - q for p, q in zip(b, a)]

    def length(d):
        return sum(c * c for c in d).sqrt()

    network = [(i, j, Decimal(k), Decimal(share) * length(difference(x[i], x[j])), Decimal(c)) for i, j, k, share, c in springs]
    for _ in range(STEPS):
        force = [[-g * c for c in velocity] for g, velocity in zip(drag, v)]
        for i, j, k, rest, c in network:
            d, w = difference(x[i], x[j]), difference(v[i], v[j])
            r = length(d)
            factor = k * (1 - rest / r) + c * sum(p * q for p, q in zip(d, w)) / (r * r)
            for axis in range(3):
                force[i][axis] += factor * d[axis]
                force[j][axis] -= factor * d[axis]
        for n in range(POINTS):
            for axis in range(3):
                v[n][axis] += h * force[n][axis] / mass[n]
                x[n][axis] += h * v[n][axis]
    for n in SHOWN:
        moved = difference(start[n], x[n])
        print(f"{{{n}, {{{', '.join(f'{c:.17g}' for c in moved)}}}, {{{', '.join(f'{c:.17g}' for c in v[n])}}}}},")


if __name__ == "__main__":
    main()
