/* Reduced models of Durometer in C: `.durom` files of studies of kind "reduction", stepped without allocation, except where the constants of a law change.
 *
 * Numbers are in SI units, in the order of the names. A model is used by one thread at a time; several models are independent.
 * Strings and arrays that a function returns belong to the model and are valid until it is closed; values change with each step. Arrays that are
 * given to a function are the caller's own: to step from the present inputs, copy them. */
#ifndef DUROMETER_H
#define DUROMETER_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct durometer_twin durometer_twin;

enum {
    DUROMETER_DONE = 0,
    /* Internal error of the program: close the model, and report the error. */
    DUROMETER_INTERNAL = 1,
    /* Null pointers, counts that differ from those of the model, or numbers that are not finite. The model has not changed. */
    DUROMETER_BAD_INPUT = 2,
    /* No equilibrium was found, or no inputs that meet the targets. After a failed step the state of the model is that before the step. */
    DUROMETER_NOT_SOLVED = 3
};

/* Opens a `.durom` file, whose path is in UTF-8. The model is at rest, with its inputs at the values of the scene at its start (for a model that moves,
 * at zero, or at the nearest ends of their ranges): see `durometer_twin_present_inputs`. Returns null if the file cannot be used, with the reason in
 * `message`, truncated to `size` bytes including the terminating null. */
durometer_twin *durometer_twin_open(const char *path, char *message, size_t size);
/* Releases a model; null is allowed. */
void durometer_twin_close(durometer_twin *twin);

/* Numbers of inputs and of quantities. The order of the inputs is that of the model, not of the study: find them by their names. */
size_t durometer_twin_inputs(const durometer_twin *twin);
size_t durometer_twin_quantities(const durometer_twin *twin);
/* Name of an input or of a quantity; null if the index is too large. */
const char *durometer_twin_input_name(const durometer_twin *twin, size_t input);
const char *durometer_twin_quantity_name(const durometer_twin *twin, size_t quantity);
/* Range of an input for which the model was made: least, largest. */
int durometer_twin_range(const durometer_twin *twin, size_t input, double range[2]);

/* Goes to the equilibrium of all `count` inputs; a model that moves takes one step in time, at whose end the inputs have these values. Does not
 * allocate, unless an input that is a constant of a law has changed: that law is then rebuilt. */
int durometer_twin_step(durometer_twin *twin, const double *inputs, size_t count);
/* Goes to inputs within their ranges at which quantities have target values within tolerances, each in the unit of its quantity, as nearly as a local
 * search finds them. Only the driving inputs are changed, not constants of laws and weights. A model that moves takes one step in time. Allocates. */
int durometer_twin_reach(durometer_twin *twin, const size_t *quantities, const double *values, const double *tolerances, size_t count);
/* Returns the model to rest. */
int durometer_twin_reset(durometer_twin *twin);
/* Time step of a model that moves, and the time since its last rest, in seconds; 0 for a static model. */
double durometer_twin_dt(const durometer_twin *twin);
double durometer_twin_time(const durometer_twin *twin);

/* Inputs of the present equilibrium. */
const double *durometer_twin_present_inputs(const durometer_twin *twin);
/* Whether the inputs are within their ranges: 1 or 0. For a model that moves: whether they have been so since the last rest and changed no faster than in
 * the training runs, and no more time has passed than in these. */
int durometer_twin_in_range(const durometer_twin *twin);
/* Quantities at the present equilibrium, their error bars (infinite out of range), and estimates of the value of the full model minus that of this
 * one. */
const double *durometer_twin_values(const durometer_twin *twin);
const double *durometer_twin_bars(const durometer_twin *twin);
const double *durometer_twin_estimates(const durometer_twin *twin);
/* Derivatives of the quantities with respect to the inputs (for a model that moves, at the end of the last step), [quantities x inputs] row by row, in an
 * array of `count` numbers. DUROMETER_NOT_SOLVED at rest, before the first step. */
int durometer_twin_sensitivities(durometer_twin *twin, double *out, size_t count);

#ifdef __cplusplus
}
#endif

#endif
