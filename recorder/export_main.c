/* shakedown-export: particles and contacts of a run for other programs. */
#include <limits.h>
#include <stdio.h>
#include <string.h>

#include "recorder/export.h"

static const char USAGE[] =
    "usage: shakedown-export DIR --vtk|--csv|--lammps-dump [-o FOLDER]\n"
    "Writes particles and contacts of all frames of DIR/run.h5 into FOLDER (default: DIR/vtk, DIR/csv,\n"
    "DIR/lammps-dump). No file is written over. SI units.\n"
    "  --vtk          particles.pvd, contacts.pvd (lines) for ParaView and VTK, and a .vtp for every frame\n"
    "  --csv          frames.csv, particles.csv, contacts.csv\n"
    "  --lammps-dump  particles.dump, contacts.dump, wall_contacts.dump; ids are ours plus 1\n";

struct arguments {
    const char *directory, *folder;
    const struct export_format *format;
    bool help;
};

static enum status argument_read(struct arguments *arguments, const char *word, const char *next, int *used)
{
    const struct export_format *format = strncmp(word, "--", 2) == 0 ? export_format_find(word + 2) : NULL;
    *used = 1;
    if (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0) {
        arguments->help = true;
    } else if (strcmp(word, "-o") == 0 || strcmp(word, "--out") == 0) {
        if (!next || !next[0])
            return status_fail(STATUS_USAGE, "%s wants a folder", word);
        arguments->folder = next;
        *used = 2;
    } else if (format) {
        if (arguments->format)
            return status_fail(STATUS_USAGE, "one format at a time: --%s or %s", arguments->format->name, word);
        arguments->format = format;
    } else if (word[0] == '-' || arguments->directory) {
        return status_fail(STATUS_USAGE, "%s: one folder of a run, and --vtk, --csv or --lammps-dump", word);
    } else {
        arguments->directory = word;
    }
    return STATUS_OK;
}

static enum status arguments_read(struct arguments *arguments, int argc, char **argv)
{
    int used;
    for (int k = 1; k < argc; k += used)
        TRY(argument_read(arguments, argv[k], k + 1 < argc ? argv[k + 1] : NULL, &used));
    if (arguments->help)
        return STATUS_OK;
    if (!arguments->directory)
        return status_fail(STATUS_USAGE, "which folder? (see --help)");
    if (!arguments->format)
        return status_fail(STATUS_USAGE, "which format? --vtk, --csv or --lammps-dump");
    return STATUS_OK;
}

static enum status work(const struct arguments *arguments)
{
    char path[PATH_MAX], folder[PATH_MAX];
    const char *directory = arguments->directory;
    if (snprintf(path, sizeof path, "%s/run.h5", directory) >= (int)sizeof path ||
        snprintf(folder, sizeof folder, "%s/%s", directory, arguments->format->name) >= (int)sizeof folder)
        return status_fail(STATUS_USAGE, "the path %s is too long", directory);
    return export_run(path, arguments->folder ? arguments->folder : folder, arguments->format, stdout);
}

int main(int argc, char **argv)
{
    struct arguments arguments = {0};
    enum status status = arguments_read(&arguments, argc, argv);
    if (status == STATUS_OK && arguments.help) {
        fputs(USAGE, stdout);
        return 0;
    }
    if (status == STATUS_OK)
        status = work(&arguments);
    return status_report("export", status);
}
