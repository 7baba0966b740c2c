// SPDX-License-Identifier: MIT
#pragma once

/// What a generated kernel says about itself. Plain C, so that kernels built with the package and kernels compiled at
/// run time (loaded from a shared library) look the same.
extern "C"
{
  /// Element tensor of `lanes` cells at once. Entry i of an array of a cell stands at [lanes * i + lane]; rows of A
  /// first. Facets between two cells (interior_facet) have the arrays of both, those of the "+" cell first: A is a
  /// vector or matrix of twice the size, every coefficient has its "+" entries, then its "-" entries, and x all nodes
  /// of "+" before those of "-".
  /// @param A element tensor, added to, shape [0] x [1]; then the outputs (size_A)
  /// @param w coefficients, coefficient k from entry offset_k, in the order of its element's dofs (blocked)
  /// @param c constants, the same for all lanes
  /// @param x node coordinates, 3 per node
  /// @param entity local facet number of all lanes (exterior facets); for interior facets the number in "+" and in "-",
  ///   then the permutation of the facet's points in "+" and in "-" (DOLFINx's facet permutations), four bits each from
  ///   the lowest
  typedef void (*impact_tabulate)(double* A, const double* w, const double* c, const double* x, int entity);

  /// Whole batches of cells, and arrays over their nodes: four entries per node for three components, aligned to 32
  /// bytes, two entries for two, and one for scalars.
  typedef struct
  {
    unsigned long long num_batches;
    const int* nodes; ///< node i of a lane of the first batch stands at [lanes * i + lane]; batches follow each other
    const double* constants;
    const double* positions; ///< four entries per node
    const double* values;    ///< of the coefficient that has components
    double* result;          ///< element vectors are added to it
    const double* scalars;   ///< of the scalar coefficient; null: the kernel has none
    /// Of each output the internal variables of the first batch, aligned to 64 bytes, read and overwritten; batches
    /// follow each other. Null for an output that is none: it is not written.
    double* const* history;
    /// Of each batch whether an internal variable may be other than +0; the others' are not read, and set where the
    /// kernel changes them. Null without internal variables.
    unsigned char* has_history;
    double* sums; ///< the kernel's sums over each cell are added to it
    /// Called for batches with points whose local equations were not solved; A is as tabulate leaves it but for
    /// outputs.
    void (*report)(const void* owner, unsigned long long batch, const double* A);
    const void* owner; ///< passed to it
  } impact_cells;

  /// Gathers, computes and scatters batch by batch: what tabulate gives, to round-off, in less time.
  typedef void (*impact_sweep)(const impact_cells* cells);

  /// A finite element as far as a kernel depends on it.
  typedef struct
  {
    const char* description; ///< basix.ufl's description, complete
    const char* kind;        ///< "node", "cell", "quadrature" or "other"
    unsigned long long hash; ///< Basix's hash of the scalar element; 0: unknown
    int degree;
    int block_size;
    int num_dofs; ///< per cell, blocked
  } impact_element;

  typedef struct
  {
    const char* name;
    impact_element element;
    int offset;   ///< of its first entry in w
    int position; ///< in the list of coefficients of the UFL form, form.coefficients()
  } impact_coefficient;

  typedef struct
  {
    const char* name;
    int size;
    int offset; ///< of its first entry in c
  } impact_constant;

  /// Values at the quadrature points that a kernel writes beside the element tensor: new internal variables and others.
  typedef struct
  {
    const char* name;
    int num_components; ///< at a point
    int offset;         ///< of its first entry in A; component c at point q stands num_components * q + c behind it
    int coefficient;    ///< that reads its committed values, number in the kernel's coefficients; -1: none
  } impact_output;

  /// A value that a kernel integrates over each cell beside the element tensor.
  typedef struct
  {
    const char* name;
    int offset; ///< of its entry in A
  } impact_sum;

  enum
  {
    IMPACT_KERNEL_ABI = 5,
    IMPACT_KERNEL_WIDTHS = 3 ///< tabulate[k] takes 1, 4, 8 cells at once
  };

  // A count stands beside its array, which costs 32 bytes of padding in each of a few hundred tables.
  // NOLINTNEXTLINE(clang-analyzer-optin.performance.Padding)
  typedef struct
  {
    int abi;
    const char* name;          ///< of the form, for example "linear_elastic.force"
    const char* signature;     ///< hash of the UFL form and of the compiler's version
    const char* integral_type; ///< "cell", "exterior_facet", "interior_facet" or "expression"
    const char* cell;          ///< "triangle", "quadrilateral", "tetrahedron", "hexahedron"
    int geometry_degree;
    int geometry_variant; ///< of Basix's Lagrange elements
    int gdim;
    const char* hypothesis; ///< of a form of the catalogue; "" for a form of the user
    int rank;
    int shape[2]; ///< of A; for an expression (points, components)
    const impact_element* arguments;
    int num_subdomains;
    const int* subdomains; ///< tags the integral belongs to; -1: everywhere
    int num_coefficients;
    const impact_coefficient* coefficients;
    int size_w;
    int num_constants;
    const impact_constant* constants;
    int size_c;
    const double* points; ///< of an expression: shape [0] x tdim reference coordinates; else null
    /// Entries of A in all: the element tensor, then outputs and sums, which are overwritten; then, where there are
    /// local unknowns, how many points could not be solved, the number of the first of them, its residual relative to
    /// the residual's scale, and its unknowns. shape[0] * shape[1] for a kernel without outputs.
    int size_A;
    int num_points; ///< that outputs are written at; 0 without outputs
    int num_outputs;
    const impact_output* outputs;
    int num_sums;
    const impact_sum* sums;
    int local_unknowns; ///< of the equations solved at each point; 0: none
    double flops;       ///< additions, multiplications and divisions per cell
    impact_tabulate tabulate[IMPACT_KERNEL_WIDTHS];
    /// Of kernels over cells with straight sides that read positions, a coefficient with as many components and at most
    /// one scalar at the nodes that they add to; null for others and where there are no vectors. Those of kernels with
    /// internal variables work in place.
    impact_sweep sweep[IMPACT_KERNEL_WIDTHS];
  } impact_kernel;
}
