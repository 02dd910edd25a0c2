#include "recorder/export.h"

#include <errno.h>
#include <inttypes.h>
#include <limits.h>
#include <string.h>
#include <sys/stat.h>

const struct export_format *export_format_find(const char *name)
{
    static const struct export_format *const formats[] = {&export_vtk, &export_csv, &export_lammps_dump};
    for (size_t k = 0; k < sizeof formats / sizeof *formats; k++) {
        if (strcmp(formats[k]->name, name) == 0)
            return formats[k];
    }
    return NULL;
}

enum status export_open(const struct export *export, const char *name, FILE **file)
{
    char path[PATH_MAX];
    if (snprintf(path, sizeof path, "%s/%s", export->folder, name) >= (int)sizeof path)
        return status_fail(STATUS_USAGE, "the path %s is too long", export->folder);
    *file = fopen(path, "wx");
    if (*file)
        return STATUS_OK;
    return status_fail(STATUS_IO, "%s: %s%s", path, strerror(errno),
                       errno == EEXIST ? "; nothing is written over: choose another folder with -o" : "");
}

enum status export_close(FILE *file)
{
    if (!file)
        return STATUS_OK;
    const bool failed = ferror(file) != 0;
    if (fclose(file) == 0 && !failed)
        return STATUS_OK;
    return status_fail(STATUS_IO, "cannot write: %s", failed ? "the disk may be full" : strerror(errno));
}

static enum status frames_write(struct export *export, struct run_frames *run, const struct export_format *format)
{
    TRY(format->begin(export));
    for (int64_t f = 0; f < run->n_frames; f++) {
        TRY(run_frames_read(run, f));
        TRY(format->frame(export, f));
    }
    return format->end(export);
}

static enum status files_write(struct run_frames *run, const char *folder, const struct export_format *format)
{
    struct export export = {.folder = folder, .run = run};
    if (mkdir(folder, 0777) != 0 && errno != EEXIST)
        return status_fail(STATUS_IO, "cannot create %s: %s", folder, strerror(errno));
    enum status status = frames_write(&export, run, format);
    for (int k = 0; k < EXPORT_FILES_MAX; k++) {
        if (status != STATUS_OK && export.file[k])
            (void)fclose(export.file[k]); /* what failed before is what is told */
        else if (status == STATUS_OK)
            status = export_close(export.file[k]);
    }
    return status;
}

enum status export_run(const char *path, const char *folder, const struct export_format *format, FILE *out)
{
    struct run_frames run;
    TRY(run_frames_open(&run, path));
    if (!run.complete)
        fprintf(stderr, "export: warning: %s is not complete: what is there is written\n", path);
    enum status status = files_write(&run, folder, format);
    if (status == STATUS_OK)
        fprintf(out, "%s: %" PRId64 " frames of %" PRId64 " particles, %" PRId64 " of them with contacts\n", folder,
                run.n_frames, run.n_particles, run.n_contact_frames);
    run_frames_close(&run);
    return status;
}
