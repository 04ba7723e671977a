#include "vdblic/io/vdb_file.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/version.h"
#include "vdblic/io/atomic_file.h"

#include <openvdb/io/Archive.h>
#include <openvdb/io/Stream.h>

#include <array>
#include <cerrno>
#include <fstream>
#include <system_error>

namespace vdblic {
namespace {

/// Messages from below may quote the damaged bytes of a file.
std::string clamped(std::string message)
{
    for (char& c : message) {
        if (c < ' ' || c > '~') c = '?';
    }
    constexpr std::size_t kLongest = 200;
    if (message.size() > kLongest) {
        message.resize(kLongest);
        message += "...";
    }
    return message;
}

void initializeOnce()
{
    static const bool done = (openvdb::initialize(), true);
    (void)done;
}

/// OpenVDB's own file writer never looks at the state of its stream; this one's stream throws.
class CheckedArchive : public openvdb::io::Archive {
  public:
    void writeTo(std::ostream& stream, const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& metadata) const
    {
        openvdb::io::Archive::write(stream, grids, /*seekable=*/true, metadata);
    }
};

/// OpenVDB puts a random identifier into each file. Replace it by one made from the content, so that equal content
/// gives equal files.
void stampIdentity(std::fstream& file)
{
    constexpr std::streamoff kIdentity = 21, kContent = kIdentity + 36; // after magic, versions and the offset flag
    file.seekg(0, std::ios::end);
    auto rest = std::size_t(file.tellg() - kContent);
    file.seekg(kContent);
    std::array<std::uint64_t, 2> hash = {0x9e3779b97f4a7c15, 0xc2b2ae3d27d4eb4f};
    std::array<std::uint64_t, 8192> block;
    while (rest > 0) {
        const std::size_t size = std::min(rest, sizeof block);
        block.fill(0);
        file.read(reinterpret_cast<char*>(block.data()), std::streamsize(size));
        for (const std::uint64_t word : block) {
            hash[0] = (hash[0] ^ word) * 0x100000001b3; // FNV-1a, by words
            hash[1] = (hash[1] ^ (hash[0] >> 29) ^ word) * 0x9e3779b97f4a7c15;
        }
        rest -= size;
    }
    const std::string text = fmt::format("{:016x}{:016x}", hash[0], hash[1]);
    file.seekp(kIdentity);
    file << text.substr(0, 8) << '-' << text.substr(8, 4) << '-' << text.substr(12, 4) << '-' << text.substr(16, 4)
         << '-' << text.substr(20);
}

} // namespace

std::string VdbFile::contents() const
{
    std::string text;
    for (const openvdb::GridBase::Ptr& grid : grids) {
        text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", grid->getName(), grid->valueType());
    }
    return text.empty() ? "no grids" : clamped(text);
}

VdbFile readVdb(const std::filesystem::path& path)
{
    initializeOnce();
    std::error_code error;
    if (!std::filesystem::exists(path, error)) throw InputError(fmt::format("{}: no such file", path.string()));
    // OpenVDB takes what a failed read leaves behind for data and may loop over it for hours; this stream throws.
    std::ifstream stream;
    errno = 0;
    try {
        stream.exceptions(std::ios::failbit | std::ios::badbit);
        stream.open(path, std::ios::binary);
        openvdb::io::Stream input(stream, /*delayLoad=*/false);
        VdbFile result;
        result.grids = *input.getGrids();
        result.metadata = *input.getMetadata();
        return result;
    } catch (const std::ios::failure&) {
        const std::string reason = stream.eof() ? "it ends too early"
                                   : errno != 0 ? std::generic_category().message(errno)
                                                : "it is damaged";
        throw InputError(fmt::format("{}: cannot be read as a .vdb file: {}", path.string(), reason));
    } catch (const std::exception& e) {
        throw InputError(fmt::format("{}: cannot be read as a .vdb file: {}", path.string(), clamped(e.what())));
    }
}

void writeVdb(const std::filesystem::path& path, const openvdb::GridCPtrVec& grids, openvdb::MetaMap metadata)
{
    initializeOnce();
    metadata.removeMeta("creator");
    metadata.insertMeta("creator", openvdb::StringMetadata(kCreator));
    AtomicFile output(path);
    errno = 0;
    try {
        std::fstream stream;
        stream.exceptions(std::ios::failbit | std::ios::badbit);
        stream.open(output.temporary(), std::ios::binary | std::ios::in | std::ios::out | std::ios::trunc);
        CheckedArchive().writeTo(stream, grids, metadata);
        stampIdentity(stream);
        stream.close();
    } catch (const std::exception& e) {
        // The stream only says that it failed; the system's last error says why.
        const std::string reason = errno != 0 ? std::generic_category().message(errno) : clamped(e.what());
        throw OutputError(fmt::format("{}: cannot be written: {}", path.string(), reason));
    }
    output.commit();
}

std::optional<double> numericMetadata(const openvdb::MetaMap& metadata, const std::string& name)
{
    const openvdb::Metadata::ConstPtr value = metadata[name];
    if (!value) return std::nullopt;
    if (const auto* d = dynamic_cast<const openvdb::DoubleMetadata*>(value.get())) return d->value();
    if (const auto* f = dynamic_cast<const openvdb::FloatMetadata*>(value.get())) return double(f->value());
    if (const auto* i = dynamic_cast<const openvdb::Int32Metadata*>(value.get())) return double(i->value());
    if (const auto* l = dynamic_cast<const openvdb::Int64Metadata*>(value.get())) return double(l->value());
    return std::nullopt;
}

} // namespace vdblic
