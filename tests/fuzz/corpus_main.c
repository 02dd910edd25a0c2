/* Runs a fuzz target without a fuzzer: fuzz_TARGET_corpus N FILE-OR-FOLDER...: gives it every file, N variations of
 * each by a fixed sequence of random numbers, and nothing at all. */
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "fuzz.h"

enum { INPUT_MAX = 1 << 16, CHANGES_MAX = 8, PATH_LENGTH = 4096 };

static int inputs; /* so far */

/* SplitMix64. */
static uint64_t random_next(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

static void give(const uint8_t *data, size_t size)
{
    (void)LLVMFuzzerTestOneInput(data, size);
    inputs++;
}

/* A few bytes become others, and sometimes the end goes. */
static size_t vary(uint8_t *bytes, size_t size, uint64_t *state)
{
    const unsigned changes = 1 + (unsigned)(random_next(state) % CHANGES_MAX);
    for (unsigned k = 0; k < changes && size > 0; k++) {
        static const uint8_t odd[] = {0, 1, 0x7f, 0x80, 0xff};
        const uint64_t choice = random_next(state);
        bytes[random_next(state) % size] = choice & 1 ? odd[choice / 2 % sizeof odd] : (uint8_t)(choice >> 8);
    }
    return random_next(state) % 8 == 0 && size > 0 ? random_next(state) % size : size;
}

static void run_file(const char *path, int variations)
{
    static uint8_t data[INPUT_MAX], varied[INPUT_MAX];
    uint64_t state = 1;
    FILE *in = fopen(path, "rb");
    if (!in) {
        fprintf(stderr, "cannot read %s\n", path);
        exit(1);
    }
    const size_t size = fread(data, 1, sizeof data, in);
    fclose(in);
    give(data, size);
    for (int k = 0; k < variations; k++) {
        memcpy(varied, data, size);
        give(varied, vary(varied, size, &state));
    }
}

static void run_folder(const char *path, int variations)
{
    struct dirent **entry;
    const int n = scandir(path, &entry, NULL, alphasort);
    if (n < 0) {
        fprintf(stderr, "cannot read %s\n", path);
        exit(1);
    }
    for (int k = 0; k < n; k++) {
        char file[PATH_LENGTH];
        snprintf(file, sizeof file, "%s/%s", path, entry[k]->d_name);
        if (entry[k]->d_name[0] != '.')
            run_file(file, variations);
        free(entry[k]);
    }
    free(entry);
}

int main(int argc, char **argv)
{
    struct stat info;
    if (argc < 3) {
        fprintf(stderr, "usage: %s VARIATIONS FILE-OR-FOLDER...\n", argv[0]);
        return 2;
    }
    give(NULL, 0);
    for (int k = 2; k < argc; k++) {
        if (stat(argv[k], &info) == 0 && S_ISDIR(info.st_mode))
            run_folder(argv[k], atoi(argv[1]));
        else
            run_file(argv[k], atoi(argv[1]));
    }
    printf("%d inputs\n", inputs);
    return inputs > 1 ? 0 : 1;
}
