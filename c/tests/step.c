/* step MODEL DAMAGED INPUT VALUE BAR: a model with one input gives the value and the bar that `durometer twin` printed, and takes wrong calls. */
#include "durometer.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void check(int holds, const char *what, int line) {
    if (!holds) {
        fprintf(stderr, "line %d: not true: %s\n", line, what);
        exit(1);
    }
}
#define CHECK(what) check((what), #what, __LINE__)

static void wrong_calls(const char *damaged) {
    char message[200], cut[8];
    double number = 0.0;
    CHECK(!durometer_twin_open("none.durom", message, sizeof message));
    CHECK(strstr(message, "none.durom") != NULL);
    CHECK(!durometer_twin_open(damaged, cut, sizeof cut));
    CHECK(strlen(cut) < sizeof cut);
    CHECK(!durometer_twin_open(damaged, NULL, 0));
    CHECK(!durometer_twin_open(NULL, message, sizeof message));
    CHECK(durometer_twin_inputs(NULL) == 0 && durometer_twin_values(NULL) == NULL);
    CHECK(durometer_twin_step(NULL, &number, 1) == DUROMETER_BAD_INPUT);
    CHECK(durometer_twin_reset(NULL) == DUROMETER_BAD_INPUT);
    durometer_twin_close(NULL);
}

static void wrong_numbers(durometer_twin *twin) {
    double two[2] = {NAN, 1.0};
    size_t beyond = 7;
    CHECK(durometer_twin_step(twin, two, 1) == DUROMETER_BAD_INPUT);
    CHECK(durometer_twin_step(twin, two, 2) == DUROMETER_BAD_INPUT);
    CHECK(durometer_twin_step(twin, NULL, 1) == DUROMETER_BAD_INPUT);
    CHECK(durometer_twin_sensitivities(twin, two, 2) == DUROMETER_BAD_INPUT);
    CHECK(durometer_twin_sensitivities(twin, NULL, 1) == DUROMETER_BAD_INPUT);
    CHECK(durometer_twin_sensitivities(twin, two, 1) == DUROMETER_NOT_SOLVED);
    CHECK(durometer_twin_reach(twin, &beyond, &two[1], &two[1], 1) == DUROMETER_BAD_INPUT);
    CHECK(durometer_twin_range(twin, 1, two) == DUROMETER_BAD_INPUT);
    CHECK(durometer_twin_input_name(twin, 1) == NULL && durometer_twin_quantity_name(twin, 1) == NULL);
}

int main(int count, char **arguments) {
    char message[200];
    double range[2], input, slope, ahead, behind, tolerance;
    size_t height = 0;
    durometer_twin *twin;
    int k;
    CHECK(count == 6);
    wrong_calls(arguments[2]);
    twin = durometer_twin_open(arguments[1], message, sizeof message);
    CHECK(twin != NULL);
    CHECK(durometer_twin_inputs(twin) == 1 && durometer_twin_quantities(twin) == 1);
    CHECK(strcmp(durometer_twin_quantity_name(twin, 0), "xmax_z_m") == 0);
    CHECK(durometer_twin_input_name(twin, 0) != NULL);
    CHECK(durometer_twin_range(twin, 0, range) == DUROMETER_DONE && range[0] == 0.0 && range[1] == 30.0);
    wrong_numbers(twin);
    CHECK(durometer_twin_present_inputs(twin)[0] == 9.81);

    input = atof(arguments[3]);
    CHECK(durometer_twin_step(twin, &input, 1) == DUROMETER_DONE);
    CHECK(durometer_twin_in_range(twin) == 1);
    CHECK(durometer_twin_values(twin)[0] == atof(arguments[4]));
    CHECK(durometer_twin_bars(twin)[0] == atof(arguments[5]));
    CHECK(fabs(durometer_twin_estimates(twin)[0]) <= durometer_twin_bars(twin)[0]);

    /* Central differences with h = 1e-4 of the range */
    CHECK(durometer_twin_sensitivities(twin, &slope, 1) == DUROMETER_DONE);
    input += 3e-3;
    CHECK(durometer_twin_step(twin, &input, 1) == DUROMETER_DONE);
    ahead = durometer_twin_values(twin)[0];
    input -= 6e-3;
    CHECK(durometer_twin_step(twin, &input, 1) == DUROMETER_DONE);
    behind = durometer_twin_values(twin)[0];
    CHECK(fabs(slope - (ahead - behind) / 6e-3) < 1e-4 * fabs(slope));

    CHECK(durometer_twin_reset(twin) == DUROMETER_DONE);
    tolerance = 1e-7;
    CHECK(durometer_twin_reach(twin, &height, &ahead, &tolerance, 1) == DUROMETER_DONE);
    CHECK(fabs(durometer_twin_values(twin)[0] - ahead) <= tolerance);
    ahead = 1.0;
    CHECK(durometer_twin_reach(twin, &height, &ahead, &tolerance, 1) == DUROMETER_NOT_SOLVED);
    input = 50.0;
    CHECK(durometer_twin_step(twin, &input, 1) == DUROMETER_DONE);
    CHECK(durometer_twin_in_range(twin) == 0 && isinf(durometer_twin_bars(twin)[0]));
    durometer_twin_close(twin);

    /* Opening and closing models does not leak memory */
    for (k = 0; k < 100; ++k) {
        twin = durometer_twin_open(arguments[1], NULL, 0);
        CHECK(twin != NULL && durometer_twin_step(twin, range, 1) == DUROMETER_DONE);
        durometer_twin_close(twin);
    }
    return 0;
}
