"""Variational forms of fem.p1 and fem.p2. ffcx compiles them to C when the program is built."""
from ufl import (Coefficient, Constant, Identity, TestFunction, TrialFunction, VectorElement, derivative, det, dot,
                 dx, grad, inner, ln, sym, tetrahedron, tr)

first_lame_pa = Constant(tetrahedron)
shear_modulus_pa = Constant(tetrahedron)
body_force = Constant(tetrahedron, shape=(3,))
density_kg_m3 = Constant(tetrahedron)
force_field = Coefficient(VectorElement("Lagrange", tetrahedron, 2))


def of_degree(degree):
    """Small and large strain: stored energy, its first and second derivative; body forces; consistent mass."""
    element = VectorElement("Lagrange", tetrahedron, degree)
    u = Coefficient(element)
    v, du = TestFunction(element), TrialFunction(element)
    small = dx(degree=2 * (degree - 1))
    strain = sym(grad(u))
    linear = (first_lame_pa / 2 * tr(strain) ** 2 + shear_modulus_pa * inner(strain, strain)) * small
    large = dx(degree=4 * (degree - 1))
    gradient = Identity(3) + grad(u)
    log_volume = ln(det(gradient))
    neo_hookean = (shear_modulus_pa / 2 * (inner(gradient, gradient) - 3) - shear_modulus_pa * log_volume
                   + first_lame_pa / 2 * log_volume ** 2) * large
    forms_of = []
    for energy in (linear, neo_hookean):
        force = derivative(energy, u, v)
        forms_of += [energy, force, derivative(force, u, du)]
    return u, forms_of, [dot(body_force, v) * dx(degree=degree), dot(force_field, v) * dx(degree=degree + 2),
                         density_kg_m3 * dot(du, v) * dx(degree=2 * degree)]


u1, (small_energy1, small_force1, small_tangent1, large_energy1, large_force1, large_tangent1), \
    (load1, field_load1, mass1) = of_degree(1)
u2, (small_energy2, small_force2, small_tangent2, large_energy2, large_force2, large_tangent2), \
    (load2, field_load2, mass2) = of_degree(2)
forms = [small_energy1, small_force1, small_tangent1, large_energy1, large_force1, large_tangent1, load1, field_load1, mass1,
         small_energy2, small_force2, small_tangent2, large_energy2, large_force2, large_tangent2, load2, field_load2, mass2]
