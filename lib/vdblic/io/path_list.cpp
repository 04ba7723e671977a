#include "vdblic/io/path_list.h"

#include <istream>

namespace vdblic {

bool PathList::separates(char c)
{
    const bool lineEnd = c == '\n' || c == '\r';
    if (c != '\0' && !lineEnd) return false;
    if (!mNul) mNul = c == '\0';
    return *mNul ? c == '\0' : lineEnd;
}

std::optional<std::string> PathList::next()
{
    std::string path;
    char c = 0;
    while (mStream.get(c)) {
        if (!separates(c)) {
            path += c;
        } else if (!path.empty()) {
            return path;
        }
    }
    return path.empty() ? std::nullopt : std::optional(path);
}

} // namespace vdblic
