# The packages VDBLIC stands on. Used by the build and, installed beside the package file, by its users.
include(CMakeFindDependencyMacro)

# OpenVDB ships its own module in a folder that CMake does not search by itself.
find_path(VDBLIC_OPENVDB_MODULE_DIR FindOpenVDB.cmake
    PATH_SUFFIXES lib/${CMAKE_LIBRARY_ARCHITECTURE}/cmake/OpenVDB lib/cmake/OpenVDB lib64/cmake/OpenVDB cmake/OpenVDB
    DOC "Folder of OpenVDB's FindOpenVDB.cmake")
mark_as_advanced(VDBLIC_OPENVDB_MODULE_DIR)
list(APPEND CMAKE_MODULE_PATH ${VDBLIC_OPENVDB_MODULE_DIR})

find_dependency(OpenVDB 10.0)
find_dependency(TBB)
find_dependency(OpenEXR CONFIG) # not by the module that OpenVDB ships, which leaves out Imath
find_dependency(PNG)
find_dependency(assimp)
find_dependency(embree 3.13)
find_dependency(glm)
find_dependency(fmt)
find_dependency(nlohmann_json)
if(VDBLIC_MPI)
    find_dependency(MPI COMPONENTS CXX)
endif()
find_dependency(PkgConfig)
pkg_check_modules(cairo REQUIRED IMPORTED_TARGET cairo)
pkg_check_modules(fontconfig REQUIRED IMPORTED_TARGET fontconfig)
