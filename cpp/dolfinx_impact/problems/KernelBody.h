// SPDX-License-Identifier: MIT
#pragma once
#include "AssembledBody.h"
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace dolfinx_impact::problems
{
/// A material as the table of kernels has it: NAME.force and NAME.tangent (kernels::find). A law with internal
/// variables has outputs at the points, "j2.small.linear" for example; its tangent is the consistent one.
struct KernelMaterial
{
  std::string name;                                     ///< "linear_elastic", "neo_hookean", or a law of one's own
  std::map<std::string, std::vector<double>> constants; ///< by name, for example E and nu
  std::string hypothesis = "";                          ///< "3d", "plane_strain", ...; empty: the only one
};

/// A material and owned cells that are made of it, for example those of a tag.
struct MaterialCells
{
  KernelMaterial material;
  std::vector<std::int32_t> cells;
};

/// Bodies of materials that have kernels: internal forces, history and tangent by kernels, nodal external forces, and
/// forms of DOLFINx for other loads.
class KernelBody : public AssembledBody
{
public:
  /// What is added to residual and tangent: less the work of loads that are forms, and its derivative.
  struct Loads
  {
    Form residual = nullptr, tangent = nullptr;
    bool has_springs = false; ///< whether springs to the ground may hold the bodies
  };

  /// @param[in] u displacement; the kernels' coefficient of this name
  /// @param[in] material of all cells
  /// @throws std::runtime_error if there are no kernels for this mesh and degree
  /// @throws std::invalid_argument if a constant is missing
  KernelBody(std::shared_ptr<dolfinx::fem::Function<double>> u, const KernelMaterial& material);
  /// @param[in] materials with their cells; a cell that is named twice has both materials
  /// @param[in] loads that are forms
  KernelBody(std::shared_ptr<dolfinx::fem::Function<double>> u, const std::vector<MaterialCells>& materials,
             const Loads& loads);

private:
  struct Made;
  explicit KernelBody(Made made);
  static Made make(std::shared_ptr<dolfinx::fem::Function<double>> u, const std::vector<MaterialCells>& materials,
                   const Loads& loads);
};
} // namespace dolfinx_impact::problems
