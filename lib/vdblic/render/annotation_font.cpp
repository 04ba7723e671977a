#include "vdblic/render/annotation_font.h"

#include <fontconfig/fontconfig.h>

#include <cstddef>
#include <memory>
#include <string_view>

namespace vdblic {
namespace {

constexpr const char* kFamily = "DejaVu Sans";

template<typename T>
using Owned = std::unique_ptr<T, void (*)(T*)>;

const FcChar8* fcText(const char* text)
{
    return reinterpret_cast<const FcChar8*>(text);
}

/// Call for each character of a text in UTF-8, up to one that is none. @param visit called with its code and its bytes
template<typename Visit>
void forCharacters(std::string_view text, const Visit& visit)
{
    while (!text.empty()) {
        FcChar32 code = 0;
        const int length = FcUtf8ToUcs4(fcText(text.data()), &code, int(text.size()));
        if (length <= 0) return;
        visit(code, text.substr(0, std::size_t(length)));
        text.remove_prefix(std::size_t(length));
    }
}

} // namespace

AnnotationFont annotationFont(const std::string& text)
{
    AnnotationFont font{kFamily, {}};
    const Owned<FcPattern> wanted(FcPatternCreate(), FcPatternDestroy);
    const Owned<FcCharSet> characters(FcCharSetCreate(), FcCharSetDestroy);
    forCharacters(text, [&](FcChar32 code, std::string_view) {
        if (code >= ' ') FcCharSetAddChar(characters.get(), code);
    });
    FcPatternAddString(wanted.get(), FC_FAMILY, fcText(kFamily));
    FcPatternAddCharSet(wanted.get(), FC_CHARSET, characters.get());
    FcPatternAddBool(wanted.get(), FC_SCALABLE, FcTrue);
    FcConfigSubstitute(nullptr, wanted.get(), FcMatchPattern);
    FcDefaultSubstitute(wanted.get());
    FcResult result = FcResultMatch;
    const Owned<FcPattern> found(FcFontMatch(nullptr, wanted.get(), &result), FcPatternDestroy);
    FcChar8* family = nullptr;
    FcCharSet* has = nullptr;
    if (!found || FcPatternGetString(found.get(), FC_FAMILY, 0, &family) != FcResultMatch ||
        FcPatternGetCharSet(found.get(), FC_CHARSET, 0, &has) != FcResultMatch) {
        return font;
    }
    font.family = reinterpret_cast<const char*>(family);
    forCharacters(text, [&](FcChar32 code, std::string_view bytes) {
        if (code >= ' ' && !FcCharSetHasChar(has, code)) font.missing += bytes;
    });
    return font;
}

} // namespace vdblic
