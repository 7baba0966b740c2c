// SPDX-License-Identifier: MIT
#pragma once

/// Numbers of contact that finds itself, docs/explicit/general_contact.md.
namespace dolfinx_impact::enforcement::general
{
/// Both ways of contact, nodes of one surface against facets of the other, bear half each.
inline constexpr double share_of_way = 0.5;
/// Stiffness of a node times dt^2 over its mass: at most, as NodePenalty, and where no nodal stiffness is known.
inline constexpr double most_per_step = 4.0 * 0.19 / 0.81, unknown_per_step = 0.5;
/// Depths as parts of the height of the cells: as deep as a spring may begin without having been in front before, and
/// as deep as it may begin at all. A node on the far side of a body is one cell behind the facets on the near side.
inline constexpr double shallow_part = 0.05, deepest_part = 0.5;
/// Cosines of angles between outward normals: of surfaces that face each other; of facets that a closed node may slide
/// to, as long as it has not been open.
inline constexpr double facing = -0.1, sliding = 0.6;
/// The same where lists are made, from which bodies may turn until the next ones.
inline constexpr double facing_of_lists = 0.5, sharp_of_lists = 0.985;
/// Facets in a list whose normals are as parallel as this to the first one's make no corner until the next lists: the
/// angle between two of them, twice 8.6 degrees, and what `facing` and `facing_of_lists` let them turn by, 36, stay
/// below the 53 of `sliding`.
inline constexpr double parallel_of_lists = 0.9888;
/// A facet of the same body that a node was behind at the start, by less than so many cells, is the far side of it.
inline constexpr double cells_behind = 3.0;
/// Edges touch between their ends: farther from them than the depth, by this factor, where they do not go on.
inline constexpr double inside_factor = 2.0;
/// Cosine of the angle between two edges, sharp and straight in the undeformed body, of which one goes on as the other.
inline constexpr double going_on = 0.94;
/// Facets are equally near if their distances differ by less than this part: of those with one closest point, on an
/// edge, that with the smaller id counts, whatever the rounding.
inline constexpr double equally_near = 1e-9;
} // namespace dolfinx_impact::enforcement::general
