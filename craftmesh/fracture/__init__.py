"""K, J and T along the crack fronts of a solved mesh.

`parameters` takes a mesh, its model and displacements, and returns K_I, K_II, K_III, J and T at each front
node, with errors. A front is cut into segments of one crystal each (`segments`) and gets a tube of elements
around it (`tube`), the integration domain. Interaction integrals with the crystal's own fields (`fields`)
are taken over the tube (`interaction`), tractions on the lips (crack faces) are added (`lip_pressure`), and
values are fitted along the front (`fit`). `rings` gives J of a body that yielded, `stress_probe` the
direction of the largest stress, `error` the error of K. Constants stand at the heads of the modules;
`options` has those that a user sets. q, as in the domain integrals of the literature, is the virtual
extension of the front: along the binormal, 1 at the front and 0 at the tube's surface.
"""
