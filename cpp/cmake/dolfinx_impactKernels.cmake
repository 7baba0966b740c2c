# SPDX-License-Identifier: MIT
# Kernels that forms/compiler wrote, compiled once for each vector width; the width in use is chosen at run time. For
# this project itself, and for those that find it by find_package(dolfinx_impact).

# Fused multiply-add is allowed (one rounding instead of two); anything that breaks IEEE rules is not.
set(IMPACT_KERNEL_FLAGS -O3 -ffp-contract=fast -fno-math-errno -Wno-unused-but-set-variable -Wno-psabi)
# Kernels with internal variables have more numbers at a time than the processor has registers: GCC saves and loads fewer
# when it orders instructions before it assigns registers, does not keep what is as cheap to compute again, looks at what
# loops need when it assigns registers, and does not put expressions together again before it orders them. Of finite J2
# hexahedra with no point yielding: 226 -> 180 ns. Kernels compiled at run time have the same flags (assembly/jit.py).
set(IMPACT_LAW_FLAGS)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  set(IMPACT_LAW_FLAGS
    -fschedule-insns -fsched-pressure -fno-tree-pre -fno-gcse -fno-tree-loop-im -fira-loop-pressure
    -fno-tree-ter)
endif()
set(IMPACT_KERNEL_WIDTHS 1 4 8)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  set(IMPACT_KERNEL_FLAGS_4 -mavx2 -mfma)
  set(IMPACT_KERNEL_FLAGS_8 -mavx512f -mavx512dq -mavx512vl -mavx512bw -mfma -mprefer-vector-width=512)
endif()

# impact_kernel_objects(NAME WIDTH SOURCE...): object library NAME of the kernels that compute WIDTH cells at once.
function(impact_kernel_objects name width)
  add_library(${name} OBJECT ${ARGN})
  target_compile_features(${name} PRIVATE cxx_std_20)
  target_compile_definitions(${name} PRIVATE IMPACT_LANES=${width})
  target_compile_options(${name} PRIVATE ${IMPACT_KERNEL_FLAGS} ${IMPACT_KERNEL_FLAGS_${width}})
  set_target_properties(${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
endfunction()

# impact_add_kernels(TARGET SOURCE [INTERNAL_VARIABLES]): the kernels of a source that
# `dolfinx-impact compile FILE.py -o FOLDER` wrote are from now on a part of TARGET, in all widths. The folder of the
# source, where the header is, is searched for includes. INTERNAL_VARIABLES: they are of a law that has some, for which
# other flags of the compiler are faster.
function(impact_add_kernels target source)
  cmake_parse_arguments(PARSE_ARGV 2 given "INTERNAL_VARIABLES" "" "")
  if(given_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "impact_add_kernels: ${given_UNPARSED_ARGUMENTS} cannot be used")
  endif()
  cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} NORMALIZE)
  cmake_path(GET source STEM stem)
  cmake_path(GET source PARENT_PATH folder)
  foreach(width ${IMPACT_KERNEL_WIDTHS})
    set(objects ${target}_${stem}_kernels_${width})
    impact_kernel_objects(${objects} ${width} ${source})
    if(given_INTERNAL_VARIABLES)
      target_compile_options(${objects} PRIVATE ${IMPACT_LAW_FLAGS})
    endif()
    target_include_directories(${objects} PRIVATE
      $<TARGET_PROPERTY:dolfinx_impact::dolfinx_impact,INTERFACE_INCLUDE_DIRECTORIES>)
    target_sources(${target} PRIVATE $<TARGET_OBJECTS:${objects}>)
  endforeach()
  target_include_directories(${target} PRIVATE ${folder})
endfunction()

# impact_compile_law(TARGET FILE.py [LAW NAME] [CELLS CELL...] [DEGREE P...] [GEOMETRY_DEGREE P...] [HYPOTHESIS H...]
#   [KERNELS KIND...] [INTERNAL_VARIABLES]): the kernels of a UFL file become a part of TARGET, which includes "FILE.h".
# They are written by `dolfinx-impact compile`, whose options these are but for the last, which impact_add_kernels
# explains, whenever the file changes; Python is needed for that alone.
function(impact_compile_law target file)
  cmake_parse_arguments(PARSE_ARGV 2 given "INTERNAL_VARIABLES" "LAW" "CELLS;DEGREE;GEOMETRY_DEGREE;HYPOTHESIS;KERNELS")
  if(given_UNPARSED_ARGUMENTS OR given_KEYWORDS_MISSING_VALUES)
    set(wrong ${given_UNPARSED_ARGUMENTS} ${given_KEYWORDS_MISSING_VALUES})
    message(FATAL_ERROR "impact_compile_law: ${wrong} cannot be used")
  endif()
  cmake_path(ABSOLUTE_PATH file BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} NORMALIZE)
  if(NOT EXISTS ${file})
    message(FATAL_ERROR "impact_compile_law: there is no file ${file}")
  endif()
  set(options)
  foreach(option CELLS DEGREE GEOMETRY_DEGREE HYPOTHESIS KERNELS)
    if(given_${option})
      string(TOLOWER --${option} name)
      string(REPLACE "_" "-" name ${name})
      list(APPEND options ${name} ${given_${option}})
    endif()
  endforeach()
  find_package(Python REQUIRED COMPONENTS Interpreter)
  # The package is found where this file was installed with it, whichever environment the interpreter is of.
  get_filename_component(site ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/../../../.. REALPATH)
  cmake_path(GET file STEM stem)
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/${target}_kernels)
  add_custom_command(
    OUTPUT ${folder}/${stem}.h ${folder}/${stem}.cpp
    COMMAND ${CMAKE_COMMAND} -E env --modify PYTHONPATH=path_list_prepend:${site} --
            ${Python_EXECUTABLE} -m dolfinx_impact.cli compile ${file} ${given_LAW} -o ${folder} ${options}
    DEPENDS ${file} ${CMAKE_CURRENT_FUNCTION_LIST_FILE}
    COMMENT "Writing the kernels of ${stem}.py"
    VERBATIM)
  add_custom_target(${target}_${stem}_kernels DEPENDS ${folder}/${stem}.h ${folder}/${stem}.cpp)
  set(kind)
  if(given_INTERNAL_VARIABLES)
    set(kind INTERNAL_VARIABLES)
  endif()
  impact_add_kernels(${target} ${folder}/${stem}.cpp ${kind})
  foreach(width ${IMPACT_KERNEL_WIDTHS})
    add_dependencies(${target}_${stem}_kernels_${width} ${target}_${stem}_kernels)
  endforeach()
  add_dependencies(${target} ${target}_${stem}_kernels)
endfunction()
