// SPDX-License-Identifier: MIT
#include "KernelTable.h"
#include "timing.h"
#include <cstddef>
#include <cstdlib>
#include <dlfcn.h>
#include <stdexcept>

namespace dolfinx_impact::kernels
{
extern const impact_kernel* const generated_table[];
extern const std::size_t generated_table_size;

namespace
{
int degree_of(const impact_kernel& k)
{
  return k.rank > 0 ? k.arguments[0].degree : k.num_coefficients > 0 ? k.coefficients[0].element.degree : 0;
}

std::string row_of(const impact_kernel& k)
{
  return std::string(k.cell) + " degree " + std::to_string(degree_of(k)) + " geometry " +
         std::to_string(k.geometry_degree) + " " + k.hypothesis;
}

/// Kernels that programs have added.
std::vector<const impact_kernel*>& added_kernels()
{
  static std::vector<const impact_kernel*> list;
  return list;
}

/// Kernels of the package, then added ones.
std::vector<const impact_kernel*> all_kernels()
{
  std::vector<const impact_kernel*> all(generated_table, generated_table + generated_table_size);
  all.insert(all.end(), added_kernels().begin(), added_kernels().end());
  return all;
}

int slot(int width)
{
  return width == 8 ? 2 : width == 4 ? 1 : 0;
}

/// A kernel of the library `path`, opened as `handle`.
const impact_kernel* loaded_kernel(void* handle, const std::string& path, const std::string& symbol)
{
  const auto* kernel = static_cast<const impact_kernel*>(dlsym(handle, symbol.c_str()));
  if (!kernel)
    throw std::runtime_error(path + " holds no kernel " + symbol + ": delete the file, it is compiled again");
  if (kernel->abi != IMPACT_KERNEL_ABI)
    throw std::runtime_error(path + " was compiled for another version of dolfinx_impact: delete the file");
  return kernel;
}
} // namespace

std::span<const impact_kernel* const> table()
{
  return {generated_table, generated_table_size};
}

std::vector<const impact_kernel*> find(const Key& key)
{
  std::vector<const impact_kernel*> found;
  std::string others;
  for (const impact_kernel* k : all_kernels())
  {
    if (k->name != key.name)
      continue;
    others += (others.empty() ? "" : "; ") + row_of(*k);
    if (k->cell == key.cell && degree_of(*k) == key.degree && k->geometry_degree == key.geometry_degree &&
        (key.hypothesis.empty() || k->hypothesis == key.hypothesis))
    {
      if (!found.empty() && std::string(found[0]->hypothesis) != k->hypothesis)
        throw std::runtime_error("kernel " + key.name + " was compiled for several hypotheses: name one");
      found.push_back(k);
    }
  }
  if (found.empty())
    throw std::runtime_error("no kernel " + key.name + " for " + key.cell + ", degree " + std::to_string(key.degree) +
                             ", geometry degree " + std::to_string(key.geometry_degree) + " " + key.hypothesis +
                             " was compiled with the package or added; " +
                             (others.empty() ? "the name is unknown" : "there are: " + others) +
                             ". Write one of your own with dolfinx-impact compile, and add it by kernels::add");
  return found;
}

void add(std::span<const impact_kernel* const> kernels)
{
  const std::vector<const impact_kernel*> known = all_kernels();
  std::vector<const impact_kernel*> fresh;
  for (const impact_kernel* k : kernels)
  {
    if (k->abi != IMPACT_KERNEL_ABI)
      throw std::runtime_error(std::string("kernel ") + k->name +
                               " was compiled for another version of dolfinx_impact: write its header anew with "
                               "dolfinx-impact compile");
    bool is_new = true;
    for (const impact_kernel* other : known)
      if (std::string(other->name) == k->name && row_of(*other) == row_of(*k))
      {
        if (std::string(other->signature) != k->signature)
          throw std::runtime_error(std::string("there is another form called ") + k->name + " for " + row_of(*k) +
                                   ": give yours another name in its UFL file");
        is_new = false;
      }
    if (is_new)
      fresh.push_back(k);
  }
  added_kernels().insert(added_kernels().end(), fresh.begin(), fresh.end());
}

std::vector<const impact_kernel*> find_signature(const std::string& signature)
{
  std::vector<const impact_kernel*> found;
  for (const impact_kernel* k : table())
    if (k->signature == signature)
      found.push_back(k);
  return found;
}

std::vector<const impact_kernel*> load(const std::string& path, const std::vector<std::string>& symbols)
{
  void* handle = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle)
    throw std::runtime_error(std::string("kernels cannot be loaded: ") + dlerror());
  std::vector<const impact_kernel*> found;
  found.reserve(symbols.size());
  for (const std::string& symbol : symbols)
    found.push_back(loaded_kernel(handle, path, symbol));
  return found;
}

int environment_width()
{
  static const int value = []
  {
    const char* text = std::getenv("IMPACT_SIMD_WIDTH");
    if (!text || !*text)
      return 0;
    const std::string w = text;
    if (w != "1" && w != "4" && w != "8")
      throw std::runtime_error("IMPACT_SIMD_WIDTH is '" + w + "': use 1, 4 or 8 cells per vector");
    return std::stoi(w);
  }();
  return value;
}

int processor_width()
{
#if defined(__x86_64__)
  static const int value = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                                   __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw")
                               ? 8
                           : __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") ? 4
                                                                                             : 1;
  return value;
#else
  return 4; // the compiler lowers vectors of four to what the machine has
#endif
}

int width(const impact_kernel& kernel, int limit)
{
  const int wanted = limit > 0 ? limit : environment_width();
  std::vector<int> available;
  for (int w : {8, 4})
    if ((wanted == 0 || w <= wanted) && w <= processor_width() && kernel.tabulate[slot(w)])
      available.push_back(w);
  available.push_back(1);
  // An expression is computed at points without a cell, on which it could be measured.
  if (wanted > 0 || available.size() == 1 || std::string(kernel.integral_type) == "expression")
    return available.front();
  return fastest_width(kernel, available);
}

impact_tabulate tabulate(const impact_kernel& kernel, int width)
{
  return kernel.tabulate[slot(width)];
}

impact_sweep sweep(const impact_kernel& kernel, int width)
{
  return kernel.sweep[slot(width)];
}
} // namespace dolfinx_impact::kernels
