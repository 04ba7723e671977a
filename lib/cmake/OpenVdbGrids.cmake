# Where OpenVDB's grids are compiled: in its library, as Debian's is, or else once, in vdblic_core. Units of this project do
# not compile them (vdblic/core/grid_instances.h). Only GCC inlines those short members that Debian's library, compiled by GCC,
# does not export.
if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    return()
endif()
include(CheckCXXSourceCompiles)
# The answer is kept for this library and compiler. A No is asked again: another missing package may have been its cause.
file(TIMESTAMP "${OpenVDB_openvdb_LIBRARY}" changed UTC)
set(asked "${OpenVDB_openvdb_LIBRARY} of ${changed}, ${CMAKE_CXX_COMPILER} ${CMAKE_CXX_COMPILER_VERSION}")
if(NOT VDBLIC_OPENVDB_HAS_GRIDS OR NOT VDBLIC_OPENVDB_ASKED STREQUAL asked)
    unset(VDBLIC_OPENVDB_HAS_GRIDS CACHE)
    set(VDBLIC_OPENVDB_ASKED "${asked}" CACHE INTERNAL "What VDBLIC_OPENVDB_HAS_GRIDS is about")
endif()
set(CMAKE_REQUIRED_LIBRARIES OpenVDB::openvdb)
set(CMAKE_REQUIRED_FLAGS -O2)
check_cxx_source_compiles([[
    #include <openvdb/openvdb.h>
    extern template class openvdb::tree::Tree<openvdb::FloatTree::RootNodeType>;
    extern template class openvdb::Grid<openvdb::FloatTree>;
    int main()
    {
        const auto grid = openvdb::FloatGrid::create(openvdb::FloatGrid::create(1.0F)->treePtr());
        return grid->getConstAccessor().isValueOn(openvdb::Coord()) ? 1 : 0;
    }
]] VDBLIC_OPENVDB_HAS_GRIDS)
unset(CMAKE_REQUIRED_FLAGS)
unset(CMAKE_REQUIRED_LIBRARIES)
# Without optimisation a unit calls small members of grids that no library exports.
target_compile_definitions(vdblic_settings INTERFACE $<$<NOT:$<CONFIG:Debug>>:VDBLIC_LIBRARY_HAS_GRIDS>)
