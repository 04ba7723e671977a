# Whether OpenVDB's library exports the virtual tables of its grids, as Debian's does: then no unit compiles them
# (vdblic/core/grid_instances.h). Two are looked for, of FloatGrid and of PointDataGrid. Only GCC inlines those short members
# that the library, compiled by GCC, does not export.
if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    return()
endif()
include(CheckCXXSourceCompiles)
set(CMAKE_REQUIRED_LIBRARIES OpenVDB::openvdb)
check_cxx_source_compiles([[
    extern "C" const char _ZTVN7openvdb5v10_04GridINS0_4tree4TreeINS2_8RootNodeINS2_12InternalNodeINS5_INS2_8LeafNodeIfLj3EEELj4EEELj5EEEEEEEEE;
    extern "C" const char _ZTVN7openvdb5v10_04GridINS0_4tree4TreeINS2_8RootNodeINS2_12InternalNodeINS5_INS0_6points17PointDataLeafNodeINS0_10PointIndexIjLj1EEELj3EEELj4EEELj5EEEEEEEEE;
    int main(int argc, char**)
    {
        const char* tables[] = {
            &_ZTVN7openvdb5v10_04GridINS0_4tree4TreeINS2_8RootNodeINS2_12InternalNodeINS5_INS2_8LeafNodeIfLj3EEELj4EEELj5EEEEEEEEE,
            &_ZTVN7openvdb5v10_04GridINS0_4tree4TreeINS2_8RootNodeINS2_12InternalNodeINS5_INS0_6points17PointDataLeafNodeINS0_10PointIndexIjLj1EEELj3EEELj4EEELj5EEEEEEEEE};
        return tables[argc & 1] == nullptr;
    }
]] VDBLIC_LIBRARY_HAS_GRIDS)
unset(CMAKE_REQUIRED_LIBRARIES)
# Without optimisation a unit calls small members of grids that no library exports.
if(VDBLIC_LIBRARY_HAS_GRIDS)
    target_compile_definitions(vdblic_settings INTERFACE $<$<NOT:$<CONFIG:Debug>>:VDBLIC_LIBRARY_HAS_GRIDS>)
endif()
