#!/usr/bin/env python3
"""Accelerations of the double pendulum, derived from its Lagrangian: nothing here knows the equations of
sim/double_pendulum.hpp. Writes lagrangian.inc, which the tests compare with:
    python3 tests/sim/lagrangian.py > tests/sim/lagrangian.inc        (Debian's python3-sympy)
Each row: leg, trunk (rad), their rates (rad/s), ankle and hip torque (N m); accelerations (rad/s^2)."""
import random

import sympy
from sympy import Rational as R

t = sympy.Symbol("t")
p1, p2 = sympy.Function("p1")(t), sympy.Function("p2")(t)
ankle, hip, g = sympy.Symbol("ankle"), sympy.Symbol("hip"), R("9.81")

# Winter's segments of a subject of 88.86 kg and 1.80 m.
mass, height = R("88.86"), R("1.80")
m_leg, m_trunk = R("0.293") * mass, R("0.678") * mass
length = R("0.491") * height
c_leg, c_trunk = R("0.553") * length, R("0.626") * R("0.288") * height
j_leg = m_leg * (R("0.326") * length) ** 2
j_trunk = m_trunk * (R("0.496") * R("0.34") * height) ** 2

# Positions of the centres of mass; angles are from upright, positive forward (x).
leg = sympy.Matrix([c_leg * sympy.sin(p1), c_leg * sympy.cos(p1)])
hip_joint = sympy.Matrix([length * sympy.sin(p1), length * sympy.cos(p1)])
trunk = hip_joint + sympy.Matrix([c_trunk * sympy.sin(p2), c_trunk * sympy.cos(p2)])


def square_of_speed(position):
    velocity = position.diff(t)
    return velocity.dot(velocity)


kinetic = (m_leg * square_of_speed(leg) + j_leg * p1.diff(t) ** 2
           + m_trunk * square_of_speed(trunk) + j_trunk * p2.diff(t) ** 2) / 2
potential = g * (m_leg * (leg[1] - c_leg) + m_trunk * (trunk[1] - length - c_trunk))
lagrangian = kinetic - potential

# Virtual work: the ankle's torque turns the leg against the ground, the hip's the trunk against the leg.
force = {p1: ankle - hip, p2: hip}
a1, a2 = sympy.symbols("a1 a2")
accelerations = {p1.diff(t, 2): a1, p2.diff(t, 2): a2}
equations = [(lagrangian.diff(q.diff(t)).diff(t) - lagrangian.diff(q) - force[q]).subs(accelerations) for q in (p1, p2)]

print("// Made by lagrangian.py; do not edit.")
random.seed(1)
for case in range(24):
    limit = R("0.5") if case % 2 else R("0.05")
    draw = lambda bound: R(str(round(random.uniform(-1, 1), 6))) * bound
    values = [draw(limit), draw(limit), draw(3 * limit), draw(5 * limit), draw(200), draw(100)]
    rates = [(p1.diff(t), values[2]), (p2.diff(t), values[3])]
    angles = [(p1, values[0]), (p2, values[1]), (ankle, values[4]), (hip, values[5])]
    numbers = lambda expression: expression.subs(rates).subs(angles)
    found = sympy.solve([sympy.N(numbers(e), 40) for e in equations], [a1, a2])
    row = [sympy.N(v, 20) for v in values] + [sympy.N(found[a1], 20), sympy.N(found[a2], 20)]
    print("{" + ", ".join(sympy.printing.sstr(v, full_prec=False) for v in row) + "},")
