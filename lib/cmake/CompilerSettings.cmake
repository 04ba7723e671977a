# What every target of this project is compiled with.
#
# Equal bytes on every machine is a contract, so nothing that changes the value of a floating-point
# expression is allowed: no contraction into fused multiply-adds, no reassociation.
add_library(vdblic_settings INTERFACE)
target_compile_options(vdblic_settings INTERFACE
    -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
    -Wno-psabi # vector types cross only inlined calls
    -Wno-missing-field-initializers # parameter structs are filled with designated initialisers
    -ffp-contract=off -fno-math-errno)
if(VDBLIC_WARNINGS_AS_ERRORS)
    target_compile_options(vdblic_settings INTERFACE -Werror)
endif()

# The least machine a binary runs on; kernels carry AVX2 and AVX-512 versions chosen when they are loaded.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    target_compile_options(vdblic_settings INTERFACE -march=x86-64-v2)
endif()

set(VDBLIC_SANITIZE "" CACHE STRING "Sanitizers to build with, as -fsanitize= takes them")
if(VDBLIC_SANITIZE)
    # Left out is what takes half the time to compile: checks of every access, most of which the address
    # sanitizer has as well.
    target_compile_options(vdblic_settings INTERFACE -fsanitize=${VDBLIC_SANITIZE} -fno-sanitize-recover=all
        -fno-omit-frame-pointer -fno-sanitize=null,object-size,vptr,alignment)
    target_link_options(vdblic_settings INTERFACE -fsanitize=${VDBLIC_SANITIZE})
endif()
