#include "sim/run/checkpoint_file.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <libgen.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { HEADER_BYTES = 512 /* HDF5 looks for its signature there too */, FORMAT_VERSION = 1, IMAGE_GROWS_BY = 1 << 20 };
#define HEADER_FORMAT                                                                                                  \
    "Shakedown checkpoint, format %d, %" PRIu64 " bytes of HDF5 follow byte 512, FNV-1a %016" PRIx64 "\n"
#define HEADER_SCAN "Shakedown checkpoint, format %d, %" SCNu64 " bytes of HDF5 follow byte 512, FNV-1a %16" SCNx64
static const uint64_t IMAGE_BYTES_MAX = 1ull << 36;

size_t checkpoint_type_size(enum checkpoint_type type)
{
    return type == CHECKPOINT_I32 || type == CHECKPOINT_F32 ? 4 : 8;
}

static hid_t memory_type(enum checkpoint_type type)
{
    const hid_t types[] = {[CHECKPOINT_I32] = H5T_NATIVE_INT32,
                           [CHECKPOINT_I64] = H5T_NATIVE_INT64,
                           [CHECKPOINT_F32] = H5T_NATIVE_FLOAT,
                           [CHECKPOINT_F64] = H5T_NATIVE_DOUBLE};
    return types[type];
}

static enum status put_failed(const char *path)
{
    return status_fail(STATUS_IO, "checkpoint: HDF5 cannot write %s", path);
}

/* Access to a file that lives in memory alone; `image` NULL: a new one. */
static hid_t memory_access(void *image, size_t size)
{
    hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    bool ok = access >= 0 && H5Eset_auto2(H5E_DEFAULT, NULL, NULL) >= 0 &&
              H5Pset_fapl_core(access, IMAGE_GROWS_BY, 0) >= 0 &&
              (!image || H5Pset_file_image(access, image, size) >= 0);
    if (ok)
        return access;
    if (access >= 0)
        H5Pclose(access);
    return H5I_INVALID_HID;
}

enum status checkpoint_image_create(hid_t *file)
{
    hid_t access = memory_access(NULL, 0);
    *file = access >= 0 ? H5Fcreate("checkpoint", H5F_ACC_TRUNC, H5P_DEFAULT, access) : H5I_INVALID_HID;
    if (access >= 0)
        H5Pclose(access);
    return *file >= 0 ? STATUS_OK : put_failed("its image");
}

void checkpoint_image_close(hid_t file)
{
    if (file >= 0)
        H5Fclose(file); /* in memory alone: nothing can be lost */
}

/* Creates a dataset and writes it; closes what it is given. */
static enum status put(hid_t file, const char *path, hid_t type, hid_t space, const void *data)
{
    hid_t links = H5Pcreate(H5P_LINK_CREATE), id = H5I_INVALID_HID;
    bool ok = type >= 0 && space >= 0 && links >= 0 && H5Pset_create_intermediate_group(links, 1) >= 0;
    if (ok)
        id = H5Dcreate2(file, path, type, space, links, H5P_DEFAULT, H5P_DEFAULT);
    ok = id >= 0 && H5Dwrite(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0;
    ok = (id < 0 || H5Dclose(id) >= 0) && ok;
    ok = (links < 0 || H5Pclose(links) >= 0) && ok;
    ok = (space < 0 || H5Sclose(space) >= 0) && ok;
    return ok ? STATUS_OK : put_failed(path);
}

enum status checkpoint_put(hid_t file, const char *path, enum checkpoint_type type, size_t count, const void *data)
{
    static const double nothing = 0;
    hsize_t size = count;
    return put(file, path, memory_type(type), H5Screate_simple(1, &size, NULL), count ? data : &nothing);
}

enum status checkpoint_put_text(hid_t file, const char *path, const char *text)
{
    hid_t type = H5Tcopy(H5T_C_S1);
    if (type < 0 || H5Tset_size(type, strlen(text) + 1) < 0)
        return put_failed(path);
    enum status status = put(file, path, type, H5Screate(H5S_SCALAR), text);
    return H5Tclose(type) >= 0 || status != STATUS_OK ? status : put_failed(path);
}

static enum status get_failed(const char *path)
{
    return status_fail(STATUS_FORMAT, "checkpoint: %s is missing or has not the expected form", path);
}

enum status checkpoint_count(hid_t file, const char *path, size_t *count)
{
    hid_t id = H5Dopen2(file, path, H5P_DEFAULT);
    hid_t space = id >= 0 ? H5Dget_space(id) : H5I_INVALID_HID;
    hssize_t n = space >= 0 ? H5Sget_simple_extent_npoints(space) : -1;
    if (space >= 0)
        H5Sclose(space);
    if (id >= 0)
        H5Dclose(id);
    *count = n < 0 ? 0 : (size_t)n;
    return n < 0 ? get_failed(path) : STATUS_OK;
}

bool checkpoint_has(hid_t file, const char *path)
{
    return H5Lexists(file, path, H5P_DEFAULT) > 0;
}

enum status checkpoint_get(hid_t file, const char *path, enum checkpoint_type type, size_t count, void *data)
{
    size_t stored;
    TRY(checkpoint_count(file, path, &stored));
    if (stored != count)
        return get_failed(path);
    hid_t id = H5Dopen2(file, path, H5P_DEFAULT);
    hid_t own = id >= 0 ? H5Dget_type(id) : H5I_INVALID_HID;
    bool ok = own >= 0 && H5Tequal(own, memory_type(type)) > 0;
    ok = ok && (count == 0 || H5Dread(id, memory_type(type), H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0);
    if (own >= 0)
        H5Tclose(own);
    if (id >= 0)
        H5Dclose(id);
    return ok ? STATUS_OK : get_failed(path);
}

enum status checkpoint_get_text(hid_t file, const char *path, char **text)
{
    hid_t id = H5Dopen2(file, path, H5P_DEFAULT);
    hid_t type = id >= 0 ? H5Dget_type(id) : H5I_INVALID_HID;
    bool ok = type >= 0 && H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0;
    *text = ok ? calloc(H5Tget_size(type) + 1, 1) : NULL;
    ok = *text && H5Dread(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, *text) >= 0;
    if (type >= 0)
        H5Tclose(type);
    if (id >= 0)
        H5Dclose(id);
    if (ok)
        return STATUS_OK;
    free(*text);
    *text = NULL;
    return get_failed(path);
}

static uint64_t hash_of(const unsigned char *bytes, uint64_t size)
{
    uint64_t hash = 0xcbf29ce484222325u;
    for (uint64_t k = 0; k < size; k++)
        hash = (hash ^ bytes[k]) * 0x100000001b3u;
    return hash;
}

/* The image where HDF5 keeps it, which is as good as `file`. */
static enum status image_bytes(hid_t file, const unsigned char **bytes, size_t *size)
{
    void *at = NULL;
    const ssize_t image = H5Fflush(file, H5F_SCOPE_LOCAL) >= 0 ? H5Fget_file_image(file, NULL, 0) : -1;
    if (image <= 0 || H5Fget_vfd_handle(file, H5P_DEFAULT, &at) < 0 || !at)
        return put_failed("its image");
    memcpy(bytes, at, sizeof *bytes); /* of the core driver: where its memory starts */
    *size = (size_t)image;
    return STATUS_OK;
}

static bool write_all(int descriptor, const unsigned char *bytes, size_t size)
{
    while (size > 0) {
        ssize_t written = write(descriptor, bytes, size);
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0)
            return false;
        bytes += written;
        size -= (size_t)written;
    }
    return true;
}

/* A rename is on disk when its folder is. */
static enum status folder_sync(const char *path)
{
    char copy[PATH_MAX];
    snprintf(copy, sizeof copy, "%s", path);
    int folder = open(dirname(copy), O_RDONLY | O_DIRECTORY);
    bool ok = folder >= 0 && (fsync(folder) == 0 || errno == EINVAL); /* EINVAL: a file system that cannot */
    int reason = errno;
    if (folder >= 0)
        close(folder); /* opened for reading */
    return ok ? STATUS_OK : status_fail(STATUS_IO, "cannot bring the folder of %s to disk: %s", path, strerror(reason));
}

struct piece {
    const unsigned char *bytes;
    size_t size;
};

static bool write_pieces(int descriptor, const struct piece *piece, int n)
{
    for (int k = 0; k < n; k++)
        if (!write_all(descriptor, piece[k].bytes, piece[k].size))
            return false;
    return true;
}

static enum status pieces_save(const struct piece *piece, int n, const char *path)
{
    char temporary[PATH_MAX];
    if (snprintf(temporary, sizeof temporary, "%s.new", path) >= (int)sizeof temporary)
        return status_fail(STATUS_IO, "the path %s is too long", path);
    int descriptor = open(temporary, O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0666);
    bool ok = descriptor >= 0 && write_pieces(descriptor, piece, n) && fsync(descriptor) == 0;
    int reason = errno;
    if (descriptor >= 0 && close(descriptor) != 0 && ok) {
        ok = false;
        reason = errno;
    }
    if (ok && rename(temporary, path) != 0) {
        ok = false;
        reason = errno;
    }
    if (ok)
        return folder_sync(path);
    if (descriptor >= 0)
        (void)unlink(temporary); /* it is of no use, and the room may be wanted */
    return status_fail(STATUS_IO, "cannot write the checkpoint %s: %s", path, strerror(reason));
}

enum status checkpoint_image_save(hid_t file, const char *path)
{
    unsigned char header[HEADER_BYTES] = {0};
    struct piece piece[2] = {{header, sizeof header}, {NULL, 0}}, *image = &piece[1];
    TRY(image_bytes(file, &image->bytes, &image->size));
    snprintf((char *)header, sizeof header, HEADER_FORMAT, FORMAT_VERSION, (uint64_t)image->size,
             hash_of(image->bytes, image->size));
    return pieces_save(piece, 2, path);
}

/* The whole file; to be freed. */
static enum status bytes_load(const char *path, unsigned char **bytes, size_t *size)
{
    struct stat information;
    FILE *file = fopen(path, "rb");
    *bytes = NULL;
    if (!file || fstat(fileno(file), &information) != 0 || !S_ISREG(information.st_mode)) {
        enum status status =
            status_fail(STATUS_IO, "cannot read the checkpoint %s: %s", path, file ? "not a file" : strerror(errno));
        if (file)
            fclose(file); /* opened for reading */
        return status;
    }
    *size = (size_t)information.st_size;
    *bytes = *size <= IMAGE_BYTES_MAX ? malloc(*size + 1) : NULL;
    enum status status = *bytes ? STATUS_OK : status_fail(STATUS_NO_MEMORY, "no memory for the checkpoint %s", path);
    if (*bytes && fread(*bytes, 1, *size, file) != *size)
        status = status_fail(STATUS_IO, "cannot read the checkpoint %s", path);
    if (*bytes)
        (*bytes)[*size] = '\0';
    fclose(file); /* opened for reading */
    return status;
}

static enum status bytes_check(const char *path, const unsigned char *bytes, size_t size)
{
    int version = 0;
    uint64_t length = 0, hash = 0;
    if (size < HEADER_BYTES || sscanf((const char *)bytes, HEADER_SCAN, &version, &length, &hash) != 3)
        return status_fail(STATUS_FORMAT, "%s is not a checkpoint of Shakedown", path);
    if (version != FORMAT_VERSION)
        return status_fail(STATUS_FORMAT, "%s: a checkpoint of format %d; this program reads format %d", path, version,
                           FORMAT_VERSION);
    if (length != size - HEADER_BYTES)
        return status_fail(STATUS_FORMAT, "%s: the checkpoint is damaged: %zu bytes instead of %" PRIu64, path,
                           size - HEADER_BYTES, length);
    if (hash_of(bytes + HEADER_BYTES, length) != hash)
        return status_fail(STATUS_FORMAT, "%s: the checkpoint is damaged: its hash does not match", path);
    return STATUS_OK;
}

enum status checkpoint_image_load(const char *path, hid_t *file)
{
    unsigned char *bytes = NULL;
    size_t size = 0;
    *file = H5I_INVALID_HID;
    enum status status = bytes_load(path, &bytes, &size);
    if (status == STATUS_OK)
        status = bytes_check(path, bytes, size);
    if (status == STATUS_OK) {
        hid_t access = memory_access(bytes + HEADER_BYTES, size - HEADER_BYTES); /* which copies it */
        if (access >= 0) {
            *file = H5Fopen("checkpoint", H5F_ACC_RDONLY, access);
            H5Pclose(access);
        }
        if (*file < 0)
            status = status_fail(STATUS_FORMAT, "%s: HDF5 cannot read the checkpoint", path);
    }
    free(bytes);
    return status;
}

enum status checkpoint_file_share(const char *path, const char *copy)
{
    char temporary[PATH_MAX];
    unsigned char *bytes = NULL;
    size_t size = 0;
    if (snprintf(temporary, sizeof temporary, "%s.new", copy) >= (int)sizeof temporary)
        return status_fail(STATUS_IO, "the path %s is too long", copy);
    (void)unlink(temporary); /* left by a kill */
    if (link(path, temporary) == 0 && rename(temporary, copy) == 0) {
        (void)unlink(temporary); /* rename does nothing if both are one file already */
        return folder_sync(copy);
    }
    enum status status = bytes_load(path, &bytes, &size);
    if (status == STATUS_OK)
        status = pieces_save(&(struct piece){bytes, size}, 1, copy);
    free(bytes);
    return status;
}
