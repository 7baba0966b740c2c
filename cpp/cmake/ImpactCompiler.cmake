# SPDX-License-Identifier: MIT
# Flags shared by every target of ours. Never -ffast-math or -Ofast: NaN checks and complementarity tests depend on IEEE.
add_library(impact_flags INTERFACE)
target_compile_options(impact_flags INTERFACE -Wall -Wextra)
if(IMPACT_WARNINGS_AS_ERRORS)
  target_compile_options(impact_flags INTERFACE -Werror)
endif()
if(IMPACT_SANITIZE)
  target_compile_options(impact_flags INTERFACE -fsanitize=${IMPACT_SANITIZE} -fno-omit-frame-pointer -g1)
  target_link_options(impact_flags INTERFACE -fsanitize=${IMPACT_SANITIZE})
endif()
# Lines that run are counted, for `make coverage`; generated kernels, which are not compiled with these flags, are left out.
# Counts of threads and of processes that end at the same time are added up. More optimisation would lose lines.
if(IMPACT_COVERAGE)
  target_compile_options(impact_flags INTERFACE -O1 --coverage -fprofile-update=atomic)
  target_link_options(impact_flags INTERFACE --coverage)
endif()

# In C++20 libstdc++'s <chrono>, which DOLFINx includes by way of spdlog, brings the printing of times and with it all of
# <format>. Every source instantiates that anew, which takes half a second. Nothing here prints times of <chrono>; whatever
# did would not compile. The name is the include guard of that header.
add_compile_definitions($<$<CXX_COMPILER_ID:GNU>:_GLIBCXX_CHRONO_IO_H>)

# What was compiled before is not compiled again. Precompiled headers need the two liberties: ccache compares their contents.
find_program(CCACHE ccache)
if(CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE})
  set(CMAKE_C_COMPILER_LAUNCHER ${CCACHE})
endif()

# impact_precompile(TARGET HEADER...): these headers, of the system and of other libraries only, are read once for the whole
# target. No source counts on it: each includes what it uses.
function(impact_precompile target)
  target_precompile_headers(${target} PRIVATE ${ARGN})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND NOT CMAKE_DISABLE_PRECOMPILE_HEADERS)
    target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-fpch-preprocess>) # for ccache
  endif()
endfunction()

# impact_unite(TARGET N): N sources at a time are one compilation, which reads headers and instantiates templates once. With
# a small N the unit of a source that was changed is still compiled in a few seconds.
function(impact_unite target number)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${number})
endfunction()

# impact_compile_together(TARGET NAME SOURCE...): these sources are one compilation; those of the target that no call names
# stay alone. Short sources go together: most of their time is spent on headers and templates that they share.
function(impact_compile_together target name)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  set_source_files_properties(${ARGN} PROPERTIES UNITY_GROUP ${name})
endfunction()
