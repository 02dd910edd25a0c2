/* bench_curves REFERENCE RUN...: how far the curves of runs of one stage lie from those of a reference run (run.h5
 * each, same packing, same samples). One line of JSON per run; what its numbers are: bench/curve_errors.h. */
#include <inttypes.h>
#include <stdio.h>

#include "bench/curve_errors.h"

static enum status compare(const char *reference, const char *path)
{
    struct curve_errors e;
    TRY(curve_errors_measure(reference, path, &e));
    printf("{\"run\": \"%s\", \"complete\": %s, \"elapsed_s\": %.6g, \"steps\": %" PRId64 ", \"exchanges\": %" PRId64
           ", \"stress\": %.4g, \"early\": %.4g, \"peak\": %.4g, \"position\": %.4g, \"strain\": %.4g, \"gain\": %.4g, "
           "\"residual\": %.4g, \"controller_residual\": %.4g}\n",
           path, e.complete ? "true" : "false", e.elapsed_s, e.steps, e.exchanges, e.stress, e.early, e.peak,
           e.position, e.strain, e.gain, e.residual, e.controller_residual);
    return STATUS_OK;
}

int main(int argc, char **argv)
{
    if (argc < 3) {
        fprintf(stderr, "usage: bench_curves REFERENCE RUN...\n");
        return STATUS_USAGE;
    }
    enum status status = STATUS_OK;
    for (int k = 2; k < argc && status == STATUS_OK; k++)
        status = compare(argv[1], argv[k]);
    return status_report("bench_curves", status);
}
