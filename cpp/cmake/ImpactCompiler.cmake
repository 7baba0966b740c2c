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
