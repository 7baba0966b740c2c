#include "NodeToSurface.h"
#include <cmath>
#include <stdexcept>

namespace impact::enforcement
{
NodalSprings NodeToSurface::springs(const double* u)
{
  if (!(_options.penalty > 0.0))
    throw std::invalid_argument("springs without a given penalty depend on the step");
  const surface::FacetElement& element = _tracking.master().displacement;
  NodalSprings out;
  out.num_masters = _rigid ? 0 : element.num_nodes();
  const std::vector<double> still(_rigid ? 0 : std::size_t(_halo->num_nodes()) * _gdim, 0.0);
  if (!_rigid)
    _tracking.advance(u, still.data());
  for (std::size_t i = 0; i < _candidates.nodes().size(); ++i)
  {
    const search::Projection at = _rigid ? rigid_point(i, u) : _tracking.locate(i, u, still.data());
    if (!std::isfinite(at.gap))
      continue;
    out.nodes.push_back(_candidates.numbers()[i]);
    out.stiffness.push_back(_share * _options.penalty * _candidates.areas()[i]);
    out.normal.insert(out.normal.end(), at.normal, at.normal + _gdim);
    if (_rigid)
      continue;
    double phi[surface::FacetElement::max_nodes];
    element.values(at.xi, phi);
    const std::int32_t* masters = _tracking.master().nodes_of(at.facet);
    out.masters.insert(out.masters.end(), masters, masters + out.num_masters);
    out.phi.insert(out.phi.end(), phi, phi + out.num_masters);
  }
  return out;
}
} // namespace impact::enforcement
