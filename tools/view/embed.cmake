# cmake -P embed.cmake: writes OUTPUT, a source that holds the files of FOLDER and the renderer of lines in SCENE
# (page_files.h).
file(GLOB paths ${FOLDER}/* ${SCENE}/scene.js ${SCENE}/data.js ${SCENE}/*.vert ${SCENE}/*.frag)
set(arrays "")
set(rows "")
set(number 0)
foreach(path ${paths})
    get_filename_component(file ${path} NAME)
    file(READ ${path} bytes HEX)
    string(REGEX REPLACE "(..)" "0x\\1," bytes "${bytes}")
    string(REGEX REPLACE "((0x..,){32})" "\\1\n" bytes "${bytes}")
    string(APPEND arrays "constexpr unsigned char file${number}[] = {\n${bytes}0};\n")
    string(APPEND rows "    {\"${file}\", text(file${number})},\n")
    math(EXPR number "${number} + 1")
endforeach()
file(WRITE ${OUTPUT} "#include \"view/page_files.h\"

#include <cstddef>
#include <utility>

namespace vdblic::view {
namespace {

${arrays}
template<std::size_t N>
std::string_view text(const unsigned char (&bytes)[N])
{
    return {reinterpret_cast<const char*>(bytes), N - 1};
}

const std::pair<std::string_view, std::string_view> kFiles[] = {
${rows}};

std::string_view typeOf(std::string_view name)
{
    if (name.ends_with(\".js\")) return \"text/javascript; charset=utf-8\";
    if (name.ends_with(\".vert\") || name.ends_with(\".frag\")) return \"text/plain; charset=utf-8\";
    if (name.ends_with(\".css\")) return \"text/css; charset=utf-8\";
    return name.ends_with(\".svg\") ? \"image/svg+xml\" : \"text/html; charset=utf-8\";
}

} // namespace

std::optional<PageFile> pageFile(std::string_view name)
{
    for (const auto& [known, bytes] : kFiles) {
        if (known == name) return PageFile{typeOf(name), bytes};
    }
    return std::nullopt;
}

} // namespace vdblic::view
")
