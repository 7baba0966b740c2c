// SPDX-License-Identifier: MIT
#include "gather_float.h"

namespace dolfinx_impact::operators
{
void gather_differences(int lanes, const double* u, int stride, const std::int32_t* dofs, int num_nodes, double scale,
                        float* w)
{
  for (int i = 0; i < num_nodes; ++i)
    for (int k = 0; k < 3; ++k)
      for (int l = 0; l < lanes; ++l)
        w[(3 * i + k) * lanes + l] =
            float(scale * (u[std::int64_t(stride) * dofs[i * lanes + l] + k] - u[std::int64_t(stride) * dofs[l] + k]));
}

void scatter_balanced(int lanes, float* A, const std::int32_t* dofs, int num_nodes, int used, double scale, double* b,
                      int stride)
{
  for (int l = 0; l < used; ++l)
    for (int k = 0; k < 3; ++k)
    {
      double sum = 0.0;
      for (int i = 1; i < num_nodes; ++i)
      {
        const double force = A[(3 * i + k) * lanes + l];
        b[std::int64_t(stride) * dofs[i * lanes + l] + k] += scale * force;
        sum += force;
      }
      b[std::int64_t(stride) * dofs[l] + k] -= scale * sum;
    }
  for (int i = 0; i < 3 * num_nodes * lanes; ++i)
    A[i] = 0.0f;
}
} // namespace dolfinx_impact::operators
