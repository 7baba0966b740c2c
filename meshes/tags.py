# SPDX-License-Identifier: MIT
"""The tag table: a physical name has the same number in every recipe and in every committed mesh.

Bodies are cell tags, surfaces are facet tags (edges in 2D). A facet carries one tag. The vertical axis is the last one
(y in 2D, z in 3D), the slave body lies above the master body (or left of it, for bars), and x is the rolling direction.
Sides of the slave body have the number of the same side of the master body plus 20.
"""

BODIES = {
    "master_body": 1,  # half-space, lower block, rail (the left rail of a joint), target bar
    "slave_body": 2,  # cylinder, sphere, punch, wedge, cone, upper block, wheel, striker bar
    "end_post": 3,  # the insulation in the gap of a rail joint
    "second_rail": 4,  # the rail on the right of a joint
    "joint_bar": 5,  # the bars beside the webs of a joint
    "glue": 6,  # the insulating layer between joint bars and webs
}

FACETS = {
    "bottom": 1,  # underside of the master body (of everything below, for a joint)
    "top": 2,  # upper side of the slave body, or of a single block
    "slave_surface": 3,  # where the slave body may touch
    "master_surface": 4,  # where the master body may be touched
    "load": 5,  # patch on which a load is meant to act
    "left": 6,  # x smallest, master body
    "right": 7,  # x largest, master body
    "front": 8,  # y smallest, master body, 3D only
    "back": 9,  # y largest, master body, 3D only
    "symmetry_x": 10,  # plane x = 0 (the axis, in axisymmetric use), both bodies
    "symmetry_y": 11,  # plane y = 0, both bodies, 3D only
    "hub": 12,  # bore of a wheel
    "free": 13,  # everything else
    "joint_left": 14,  # end face of the left rail, at the gap
    "joint_right": 15,  # end face of the right rail, at the gap
    "post_left": 16,  # face of an end post that is not glued, towards the left rail
    "post_right": 17,  # the same towards the right rail
    "web": 18,  # side of the web of a joint that faces bars of another mesh
    "bar_face": 19,  # face of such bars towards the web
    "slave_left": 26,
    "slave_right": 27,
    "slave_front": 28,
    "slave_back": 29,
}

NAMES = {**BODIES, **FACETS}
assert len(NAMES) == len(BODIES) + len(FACETS), "a name is a body or a surface, not both"
assert len(set(FACETS.values())) == len(FACETS) and len(set(BODIES.values())) == len(BODIES)


def name_of(number: int, kind: str = "facet") -> str:
    """Name of a tag number; `kind` is "facet" or "body". An unknown number gives its digits."""
    table = {"facet": FACETS, "body": BODIES}[kind]
    return next((name for name, value in table.items() if value == number), str(number))
