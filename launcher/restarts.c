#include "launcher/restarts.h"

static const double HOUR_S = 3600;

bool restarts_allow(struct restarts *restarts, int limit, double now_s)
{
    int n = 0;
    for (int k = 0; k < restarts->n; k++)
        if (now_s - restarts->at_s[k] < HOUR_S)
            restarts->at_s[n++] = restarts->at_s[k];
    restarts->n = n;
    if (n >= limit || n >= RESTARTS_MAX)
        return false;
    restarts->at_s[restarts->n++] = now_s;
    return true;
}
