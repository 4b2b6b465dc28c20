"""K, J and T along the front of a solved mesh.

In come a mesh, its model and displacements, out come K_I, K_II, K_III, J and T at each node of the fronts,
with errors (`parameters`). Each front is parted into segments of one crystal (`segments`) and gets a tube
of elements (`tube`). Interaction integrals with the crystal's own fields (`fields`) are taken over it
(`interaction`), tractions on the lips added (`lip_pressure`), and values fitted along the front (`fit`).
`rings` gives J where the body flowed, `stress_probe` the direction of the largest stress, `error` how far
K may be off. Numbers stand at the heads of the modules; `options` has the user's.
"""
