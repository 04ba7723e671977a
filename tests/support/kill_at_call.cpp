/// Preloaded into a tool, kills it as SIGKILL does at a call that brings a file to the disk. VDBLIC_KILL_AT names the
/// call and counts it, as in `fsync 3`. Of what is written a part is there then; nothing is flushed, named or renamed.
/// VDBLIC_KILL_BY may have the number of another signal, as of SIGSTOP: the call is made when the tool goes on.
#include <atomic>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

namespace {

/// Whether it is the turn of this call.
bool isItsTurn(const char* name)
{
    const char* const given = std::getenv("VDBLIC_KILL_AT");
    const std::size_t length = std::strlen(name);
    if (!given || std::strncmp(given, name, length) != 0 || given[length] != ' ') return false;
    static std::atomic<int> calls = 0;
    return ++calls == std::atoi(given + length);
}

void giveSignal()
{
    const char* const given = std::getenv("VDBLIC_KILL_BY");
    ::kill(::getpid(), given ? std::atoi(given) : SIGKILL);
}

bool isFile(int descriptor)
{
    struct stat status {};
    return ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
}

template<class Function>
Function* next(const char* name)
{
    return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

} // namespace

extern "C" {

ssize_t writev(int descriptor, const iovec* parts, int count)
{
    static auto* const writev = next<ssize_t(int, const iovec*, int)>("writev");
    if (!isFile(descriptor) || !isItsTurn("writev")) return writev(descriptor, parts, count);
    const ssize_t part = writev(descriptor, parts, 1);
    giveSignal();
    return part;
}

int fsync(int descriptor)
{
    static auto* const fsync = next<int(int)>("fsync");
    if (isItsTurn("fsync")) giveSignal();
    return fsync(descriptor);
}

int linkat(int fromFolder, const char* from, int toFolder, const char* to, int flags)
{
    static auto* const linkat = next<int(int, const char*, int, const char*, int)>("linkat");
    if (isItsTurn("linkat")) giveSignal();
    return linkat(fromFolder, from, toFolder, to, flags);
}

int rename(const char* from, const char* to)
{
    static auto* const rename = next<int(const char*, const char*)>("rename");
    if (isItsTurn("rename")) giveSignal();
    return rename(from, to);
}
}
