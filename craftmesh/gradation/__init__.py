"""The gradation: a surface's edges fitted to the sizing, step by step, each step behind the same guards.

The way through the room: `gradate` (the stage) prepares the surface (`tied_nodes`, `preprocess`,
`locality`), puts it into working arrays (`state`), runs rounds of `passes`, then `cleaning` and
`narrow_places`, and says what was done (`report`). One file in `kernels` holds one operation.

Words:
- patch: the facets of one pair of sides and one kind. Feature edge: one that is not between two facets of
  one patch; the lines of feature edges are junction lines, box edges, the crack's traces and its front.
- rank of a vertex: 0 inside a patch, 1 on a junction line, 2 where lines end or meet.
- flags of a vertex: the box planes that hold it, whether it lies on the crack and on its front.
- score of a facet: 1 at a smallest angle of 15 or a largest of 135 degrees, more when better.
- slot: the number of a grain or void among all volumes; -1 is the exterior.
- star: the facets that an operation changes, with the corners they would get; dying facets go.
- cone: the volume between a facet and a point; the cones over a star tell what its grains gain.
- drift: what a grain's volume has gained since the start, summed over all operations.
- home of a vertex: the first place it had. Witness: the home of a vertex that is gone or has moved, kept by
  a facet that passes it closely enough. An operation sets the witnesses of its star loose, finds a facet
  near each, and settles them there.
- ear: an edge inside the crack that joins two vertices of its front (surface.front); it stays shut.
- thin end: where the two border lines of a patch meet and its facets are thin; it closes by a collapse
  across. Remnant: the last facet of a contact that has gone, between three junction points.
- limits: the bounds of a pass. Refusal: why an operation was not made, counted by reason.
"""
