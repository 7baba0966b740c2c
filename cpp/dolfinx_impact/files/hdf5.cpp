// SPDX-License-Identifier: MIT
#include "hdf5.h"
#include <algorithm>
#include <functional>
#include <hdf5.h>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <utility>
#if __has_include(<H5FDdevelop.h>) // since HDF5 1.14
#include <H5FDdevelop.h>
#endif

namespace dolfinx_impact::files
{
namespace
{
/// Errors of HDF5 are exceptions here: nothing is printed meanwhile.
class Silence
{
public:
  Silence()
  {
    H5Eget_auto2(H5E_DEFAULT, &_function, &_data);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Silence() { H5Eset_auto2(H5E_DEFAULT, _function, _data); }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

private:
  H5E_auto2_t _function = nullptr;
  void* _data = nullptr;
};

/// What HDF5 says of the innermost of its functions that failed.
std::string last_error()
{
  std::string out;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned number, const H5E_error2_t* error, void* text)
      {
        if (number == 0 && error->desc)
          *static_cast<std::string*>(text) = error->desc;
        return herr_t(0);
      },
      &out);
  return out.empty() ? "" : ": " + out;
}

template <typename T>
T checked(T result, const std::string& what)
{
  if (result < 0)
    throw std::runtime_error("HDF5 cannot " + what + last_error());
  return result;
}

/// An object of HDF5 that is closed at the end of its scope.
class Handle
{
public:
  Handle(hid_t id, herr_t (*close)(hid_t), const std::string& what) : _id(checked(id, what)), _close(close) {}
  ~Handle() { _close(_id); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return _id; }

private:
  hid_t _id;
  herr_t (*_close)(hid_t);
};

// --- HDF5's driver of files in memory ---

/// A file as HDF5 has it open: begins with HDF5's own part.
struct OpenFile
{
  H5FD_t common = {};
  FileInMemory* memory = nullptr;
  haddr_t end_of_allocated = 0;
};

struct DriverInfo
{
  FileInMemory* memory;
};

OpenFile& open_file(H5FD_t* file)
{
  return *reinterpret_cast<OpenFile*>(file);
}

const OpenFile& open_file(const H5FD_t* file)
{
  return *reinterpret_cast<const OpenFile*>(file);
}

H5FD_t* driver_open(const char*, unsigned, hid_t properties, haddr_t)
{
  const auto* info = static_cast<const DriverInfo*>(H5Pget_driver_info(properties));
  auto* file = new (std::nothrow) OpenFile;
  if (!info || !file)
    return nullptr;
  file->memory = info->memory;
  return &file->common;
}

herr_t driver_close(H5FD_t* file)
{
  delete &open_file(file);
  return 0;
}

herr_t driver_query(const H5FD_t*, unsigned long* flags)
{
  if (flags)
    *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
             H5FD_FEAT_AGGREGATE_SMALLDATA;
  return 0;
}

haddr_t driver_get_eoa(const H5FD_t* file, H5FD_mem_t)
{
  return open_file(file).end_of_allocated;
}

herr_t driver_set_eoa(H5FD_t* file, H5FD_mem_t, haddr_t address)
{
  open_file(file).end_of_allocated = address;
  return 0;
}

haddr_t driver_get_eof(const H5FD_t* file, H5FD_mem_t)
{
  return open_file(file).memory->size();
}

herr_t driver_read(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t address, std::size_t size, void* data)
{
  open_file(file).memory->read(address, {static_cast<std::byte*>(data), size});
  return 0;
}

herr_t driver_write(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t address, std::size_t size, const void* data)
{
  try
  {
    open_file(file).memory->write(address, {static_cast<const std::byte*>(data), size});
    return 0;
  }
  catch (const std::bad_alloc&) // exceptions must not pass through HDF5
  {
    return -1;
  }
}

herr_t driver_truncate(H5FD_t* file, hid_t, hbool_t)
{
  open_file(file).memory->resize(open_file(file).end_of_allocated);
  return 0;
}

/// The driver, registered while HDF5 is used in this way. HDF5 has changed the order of the members: they are set by
/// name.
Handle driver()
{
  static const H5FD_class_t description = []
  {
    H5FD_class_t out = {};
#ifdef H5FD_CLASS_VERSION
    out.version = H5FD_CLASS_VERSION;
    out.value = 6207; // any beyond those that HDF5 and its group reserve
#endif
    out.name = "dolfinx_impact_memory";
    out.maxaddr = haddr_t(1) << 62;
    out.fc_degree = H5F_CLOSE_STRONG;
    out.fapl_size = sizeof(DriverInfo);
    out.open = driver_open;
    out.close = driver_close;
    out.query = driver_query;
    out.get_eoa = driver_get_eoa;
    out.set_eoa = driver_set_eoa;
    out.get_eof = driver_get_eof;
    out.read = driver_read;
    out.write = driver_write;
    out.truncate = driver_truncate;
    for (H5FD_mem_t& type : out.fl_map)
      type = H5FD_MEM_DEFAULT;
    return out;
  }();
  return Handle(H5FDregister(&description), H5FDunregister, "register a driver for files in memory");
}

// --- attributes ---

std::size_t entries(const std::vector<std::size_t>& shape)
{
  return std::accumulate(shape.begin(), shape.end(), std::size_t(1), std::multiplies<>());
}

struct WrittenAttribute
{
  hid_t file;
  const std::string& name;

  void operator()(std::monostate) const
  {
    throw std::invalid_argument("the attribute " + name + " is no text, number or array");
  }
  void operator()(const std::string& text) const
  {
    const Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "copy a type");
    checked(H5Tset_size(type, H5T_VARIABLE), "make a type of texts");
    checked(H5Tset_cset(type, H5T_CSET_UTF8), "make a type of texts");
    const char* data = text.c_str();
    write(type, nullptr, &data);
  }
  void operator()(std::int64_t number) const { write(H5T_NATIVE_INT64, nullptr, &number); }
  void operator()(double number) const { write(H5T_NATIVE_DOUBLE, nullptr, &number); }
  void operator()(const Numbers& numbers) const { write(H5T_NATIVE_DOUBLE, &numbers.shape, numbers.values.data()); }

  void write(hid_t type, const std::vector<std::size_t>* shape, const void* data) const
  {
    const std::vector<hsize_t> sizes(shape ? shape->begin() : std::vector<std::size_t>::const_iterator(),
                                     shape ? shape->end() : std::vector<std::size_t>::const_iterator());
    const Handle space(shape ? H5Screate_simple(int(sizes.size()), sizes.data(), nullptr) : H5Screate(H5S_SCALAR),
                       H5Sclose, "make the attribute " + name);
    const Handle attribute(H5Acreate2(file, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                           "make the attribute " + name);
    if (!shape || entries(*shape) > 0) // HDF5 refuses to write nothing
      checked(H5Awrite(attribute, type, data), "write the attribute " + name);
  }
};

std::vector<std::size_t> shape_of(hid_t space)
{
  const int rank = checked(H5Sget_simple_extent_ndims(space), "read a shape");
  std::vector<hsize_t> sizes(rank);
  checked(H5Sget_simple_extent_dims(space, sizes.data(), nullptr), "read a shape");
  return {sizes.begin(), sizes.end()};
}

Value read_text(hid_t attribute, hid_t type, const std::string& name)
{
  const Handle memory(H5Tcopy(H5T_C_S1), H5Tclose, "copy a type");
  checked(H5Tset_cset(memory, H5Tget_cset(type)), "make a type of texts");
  if (checked(H5Tis_variable_str(type), "read a type") > 0)
  {
    checked(H5Tset_size(memory, H5T_VARIABLE), "make a type of texts");
    char* text = nullptr;
    checked(H5Aread(attribute, memory, &text), "read the attribute " + name);
    const std::unique_ptr<char, herr_t (*)(void*)> owner(text, H5free_memory);
    return text ? std::string(text) : std::string();
  }
  std::string text(H5Tget_size(type) + 1, '\0');
  checked(H5Tset_size(memory, text.size()), "make a type of texts");
  checked(H5Aread(attribute, memory, text.data()), "read the attribute " + name);
  return std::string(text.c_str());
}

Value read_value(hid_t attribute, const std::string& name)
{
  const Handle type(H5Aget_type(attribute), H5Tclose, "read a type");
  const Handle space(H5Aget_space(attribute), H5Sclose, "read a shape");
  const H5T_class_t kind = H5Tget_class(type);
  const H5S_class_t extent = H5Sget_simple_extent_type(space);
  if (extent == H5S_SCALAR && kind == H5T_STRING)
    return read_text(attribute, type, name);
  if (kind != H5T_INTEGER && kind != H5T_FLOAT)
    return {};
  if (extent == H5S_SCALAR && kind == H5T_INTEGER)
  {
    std::int64_t number = 0;
    checked(H5Aread(attribute, H5T_NATIVE_INT64, &number), "read the attribute " + name);
    return number;
  }
  if (extent == H5S_SCALAR)
  {
    double number = 0.0;
    checked(H5Aread(attribute, H5T_NATIVE_DOUBLE, &number), "read the attribute " + name);
    return number;
  }
  if (extent != H5S_SIMPLE)
    return {};
  Numbers numbers{shape_of(space), {}};
  numbers.values.resize(entries(numbers.shape));
  if (!numbers.values.empty())
    checked(H5Aread(attribute, H5T_NATIVE_DOUBLE, numbers.values.data()), "read the attribute " + name);
  return numbers;
}

Attributes read_attributes(hid_t file)
{
  std::vector<std::string> names;
  checked(H5Aiterate2(
              file, H5_INDEX_NAME, H5_ITER_NATIVE, nullptr,
              [](hid_t, const char* name, const H5A_info_t*, void* out)
              {
                static_cast<std::vector<std::string>*>(out)->emplace_back(name);
                return herr_t(0);
              },
              &names),
          "list the attributes");
  Attributes out;
  for (const std::string& name : names)
  {
    const Handle attribute(H5Aopen(file, name.c_str(), H5P_DEFAULT), H5Aclose, "open the attribute " + name);
    out.push_back({name, read_value(attribute, name)});
  }
  return out;
}

// --- tables ---

Table read_table(hid_t dataset)
{
  const Handle type(H5Dget_type(dataset), H5Tclose, "read a type");
  const Handle space(H5Dget_space(dataset), H5Sclose, "read a shape");
  Table out{shape_of(space), Kind::other};
  if (H5Tequal(type, H5T_NATIVE_DOUBLE) > 0)
    out.kind = Kind::real;
  else if (H5Tequal(type, H5T_NATIVE_INT64) > 0)
    out.kind = Kind::whole;
  const haddr_t offset = H5Dget_offset(dataset);
  out.offset = offset == HADDR_UNDEF ? -1 : std::int64_t(offset); // in chunks, or without rows
  return out;
}

Tables read_tables(hid_t file)
{
  std::vector<std::string> names;
  checked(H5Lvisit(
              file, H5_INDEX_NAME, H5_ITER_NATIVE,
              [](hid_t, const char* name, const auto*, void* out)
              {
                static_cast<std::vector<std::string>*>(out)->emplace_back(name);
                return herr_t(0);
              },
              &names),
          "list the tables");
  Tables out;
  for (const std::string& name : names)
  {
    const Handle object(H5Oopen(file, name.c_str(), H5P_DEFAULT), H5Oclose, "open " + name);
    if (H5Iget_type(object) == H5I_DATASET)
      out.emplace(name, read_table(object));
  }
  return out;
}
} // namespace

std::size_t Table::size() const
{
  return entries(shape);
}

const Value* Structure::attribute(const std::string& name) const
{
  const auto found = std::ranges::find(attributes, name, &Attribute::name);
  return found == attributes.end() ? nullptr : &found->value;
}

FileInMemory lay_out(const Attributes& attributes, Tables& tables)
{
  const Silence silence;
  FileInMemory out;
  {
    const Handle in_memory = driver();
    const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "make properties");
    const DriverInfo info{&out};
    checked(H5Pset_driver(access, in_memory, &info), "write to memory");
    checked(H5Pset_fclose_degree(access, H5F_CLOSE_STRONG), "make properties");
    const Handle file(H5Fcreate("checkpoint", H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose, "lay out a file");
    for (const Attribute& a : attributes)
      std::visit(WrittenAttribute{file, a.name}, a.value);
    const Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "make properties");
    checked(H5Pset_alloc_time(layout, H5D_ALLOC_TIME_EARLY), "make properties");
    checked(H5Pset_fill_time(layout, H5D_FILL_TIME_NEVER), "make properties");
    const Handle groups(H5Pcreate(H5P_LINK_CREATE), H5Pclose, "make properties");
    checked(H5Pset_create_intermediate_group(groups, 1), "make properties");
    for (auto& [name, table] : tables)
    {
      const std::vector<hsize_t> sizes(table.shape.begin(), table.shape.end());
      const Handle space(H5Screate_simple(int(sizes.size()), sizes.data(), nullptr), H5Sclose, "make a table");
      const hid_t type = table.kind == Kind::whole ? H5T_NATIVE_INT64 : H5T_NATIVE_DOUBLE;
      const Handle dataset(H5Dcreate2(file, name.c_str(), type, space, groups, layout, H5P_DEFAULT), H5Dclose,
                           "make the table " + name);
      table.offset = table.size() > 0 ? std::int64_t(H5Dget_offset(dataset)) : 0;
    }
    checked(H5Fflush(file, H5F_SCOPE_LOCAL), "lay out a file");
  }
  return out;
}

Structure read_structure(const std::filesystem::path& path)
{
  const Silence silence;
  const Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, "open the file");
  return {read_attributes(file), read_tables(file)};
}
} // namespace dolfinx_impact::files
