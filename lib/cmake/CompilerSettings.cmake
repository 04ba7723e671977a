# What every target of this project is compiled with.
#
# Equal bytes on every machine is a contract, so nothing that changes the value of a floating-point
# expression is allowed: no contraction into fused multiply-adds, no reassociation.
add_library(vdblic_settings INTERFACE)
target_compile_options(vdblic_settings INTERFACE
    -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
    -Wno-psabi # vector types cross only inlined calls
    -Wno-missing-field-initializers # parameter structs are filled with designated initialisers
    -ffp-contract=off -fno-math-errno
    -fPIC -fno-semantic-interposition) # the Python module is a shared library of the same objects
if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang" AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 16)
    target_compile_options(vdblic_settings INTERFACE
        -Wno-enum-constexpr-conversion # of Boost 1.74, below OpenVDB
        -Wno-deprecated-declarations) # in std::stable_sort of GCC 12
endif()
if(VDBLIC_WARNINGS_AS_ERRORS)
    target_compile_options(vdblic_settings INTERFACE -Werror)
endif()

# The least machine a binary runs on. GCC's kernels carry AVX2 and AVX-512 versions, chosen when they are loaded; with
# Clang they are for this machine alone.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    set(VDBLIC_MACHINE x86-64-v2 CACHE STRING "The least machine that binaries run on, as -march= takes it")
    target_compile_options(vdblic_settings INTERFACE -march=${VDBLIC_MACHINE})
    if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
        # Tuned for no machine in particular, its kernels for AVX2 take 6 to 16 % more time.
        target_compile_options(vdblic_settings INTERFACE -mtune=haswell)
    endif()
endif()

# A second build of the same sources takes seconds. What is precompiled depends on headers alone, never on their times.
find_program(VDBLIC_CCACHE ccache)
mark_as_advanced(VDBLIC_CCACHE)
if(VDBLIC_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
    set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env
        CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime ${VDBLIC_CCACHE})
    target_compile_options(vdblic_settings INTERFACE $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>
        "$<$<CXX_COMPILER_ID:Clang>:SHELL:-Xclang -fno-pch-timestamp>")
endif()

set(VDBLIC_SANITIZE "" CACHE STRING "Sanitizers to build with, as -fsanitize= takes them")
if(VDBLIC_SANITIZE)
    # Left out is what takes half the time to compile: checks of every access, most of which the address
    # sanitizer has as well.
    target_compile_options(vdblic_settings INTERFACE -fsanitize=${VDBLIC_SANITIZE} -fno-sanitize-recover=all
        -fno-omit-frame-pointer -fno-sanitize=null,object-size,vptr,alignment)
    target_link_options(vdblic_settings INTERFACE -fsanitize=${VDBLIC_SANITIZE})
endif()
