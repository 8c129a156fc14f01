#include "plotter.h"

#include <math.h>
#include <string.h>

#include "board.h"
#include "board_constants.h"

/* On an AVR a constant text would otherwise take memory. */
#ifdef __AVR__
#include <avr/pgmspace.h>
#define STORED PROGMEM
#define stored_char(at) ((char)pgm_read_byte(at))
#else
#define STORED
#define stored_char(at) (*(at))
#endif

/* Longest line that is sent; the Arduino's ring takes 127 bytes. */
#define SENT_BYTES 110u

static const char help_text[] STORED =
    "# on: sense voltage; needed first, and after every trip\n"
    "# target 2.0 [20]: follow it [" MW_PLOT_UNIT "] for 20 s; 30 s if not said, 120 s at most\n"
    "# drive 1.5 [20]: hold a voltage [V], as long\n"
    "# sweep: drive up and down once in 90 s\n"
    "# sense: back to the sense voltage    stop: drive off\n"
    "# help, plot (numbers only)\n"
    "# Nobody need keep sending: a command ends by itself, and the drive goes to the sense\n"
    "# voltage; five minutes without a command, and it is off.\n";
static const char hello_text[] STORED = "# musclewire on " MW_BOARD_NAME ": type help\n";
static const char on_text[] STORED = "# on, at the sense voltage\n";
static const char off_text[] STORED = "# off\n";
static const char over_text[] STORED = "# time is over: sense voltage\n";
static const char alone_text[] STORED = "# no command for five minutes: off\n";
static const char not_on_text[] STORED = "# refused: type on first\n";
static const char range_text[] STORED = "# refused: " MW_PLOT_RANGES "\n";
static const char unknown_text[] STORED = "# what is that? type help\n";
static const char event_names[] STORED = MW_EVENT_NAMES;

static void say(mw_plotter *plotter, const char *text)
{
    plotter->said = text;
}

/* What a line is made of. */
typedef struct {
    char bytes[SENT_BYTES];
    uint8_t length;
} text_line;

static void add_char(text_line *line, char byte)
{
    if (line->length < SENT_BYTES) {
        line->bytes[line->length++] = byte;
    }
}

/* Adds a stored text up to its end or the end of its line; returns where it goes on. */
static const char *add_stored(text_line *line, const char *text)
{
    char byte;
    while ((byte = stored_char(text)) != '\0') {
        text++;
        if (byte == '\n') {
            break;
        }
        add_char(line, byte);
    }
    return text;
}

static void add_number(text_line *line, float value, uint8_t digits)
{
    char reversed[12]; /* a million with three digits, the point and one to spare */
    uint8_t count = 0;
    float scaled = fabsf(value);
    if (!(scaled < 1.0e6f)) {
        add_char(line, 'n');
        add_char(line, 'a');
        add_char(line, 'n');
        return;
    }
    for (uint8_t i = 0; i < digits; i++) {
        scaled *= 10.0f;
    }
    uint32_t whole = (uint32_t)(scaled + 0.5f);
    if (value < 0.0f && whole > 0u) {
        add_char(line, '-');
    }
    do {
        reversed[count++] = (char)('0' + (char)(whole % 10u));
        whole /= 10u;
        if (count == digits) {
            reversed[count++] = '.';
        }
    } while (whole > 0u || count < digits + 2u);
    while (count > 0u) {
        add_char(line, reversed[--count]);
    }
}

static bool send_line(text_line *line)
{
    add_char(line, '\r');
    add_char(line, '\n');
    return board_put((const uint8_t *)line->bytes, line->length);
}

static const char target_label[] STORED = "target_" MW_PLOT_UNIT ":";
static const char estimate_label[] STORED = " estimate_" MW_PLOT_UNIT ":";
static const char resistance_label[] STORED = " resistance_ohm:";
static const char drive_label[] STORED = " drive_v:";

void mw_plotter_numbers(const mw_plot *plot)
{
    text_line line;
    line.length = 0;
    (void)add_stored(&line, target_label);
    add_number(&line, plot->target * MW_PLOT_SCALE, 2);
    (void)add_stored(&line, estimate_label);
    add_number(&line, plot->estimate * MW_PLOT_SCALE, 2);
    (void)add_stored(&line, resistance_label);
    add_number(&line, plot->resistance_ohm, 3);
    (void)add_stored(&line, drive_label);
    add_number(&line, plot->drive_v, 3);
    (void)send_line(&line);
}

/* Sends one line of what is still to be said; returns whether there was one. */
static bool send_said(mw_plotter *plotter)
{
    text_line line;
    line.length = 0;
    if (plotter->said == NULL) {
        return false;
    }
    const char *rest = add_stored(&line, plotter->said);
    if (send_line(&line)) { /* without room the line comes with the next tick */
        plotter->said = stored_char(rest) == '\0' ? NULL : rest;
    }
    return true;
}

static const char tripped_text[] STORED = "# protection: ";
static const char reading_text[] STORED = " at [ohm] ";
static const char to_sense_text[] STORED = ", at the sense voltage";
static const char switched_off_text[] STORED = ", off";

/* Sends the event that has changed the state; returns whether there was one. */
static bool send_change(mw_plotter *plotter)
{
    text_line line;
    const char *name = event_names;
    if (!plotter->changed) {
        return false;
    }
    line.length = 0;
    (void)add_stored(&line, tripped_text);
    for (uint8_t number = 0; number < plotter->event; number++) {
        while (stored_char(name++) != '\n') {
        }
    }
    (void)add_stored(&line, name);
    (void)add_stored(&line, reading_text);
    add_number(&line, plotter->resistance_ohm, 2);
    (void)add_stored(&line, mw_state_drives(plotter->state) ? to_sense_text : switched_off_text);
    plotter->changed = !send_line(&line);
    return true;
}

void mw_plotter_changed(mw_plotter *plotter, uint8_t state, uint8_t event, float resistance_ohm)
{
    plotter->resistance_ohm = resistance_ohm;
    plotter->state = state;
    plotter->event = event;
    plotter->changed = event != MW_EVENT_NONE && event != MW_EVENT_STOPPED;
    if (!mw_state_drives(state)) {
        plotter->task = MW_TEXT_REST;
    }
}

void mw_plotter_start(mw_plotter *plotter, uint8_t event_at_reset)
{
    memset(plotter, 0, sizeof *plotter);
#ifdef MW_TEXT_AT_START
    plotter->on = true;
    say(plotter, hello_text);
    mw_plotter_changed(plotter, MW_STATE_OFF, event_at_reset, 0.0f);
#else
    (void)event_at_reset;
#endif
}

/* Back to the sense voltage, or for a board that is not armed to nothing. */
static void rest(mw_plotter *plotter, mw_control_loop *loop)
{
    plotter->task = MW_TEXT_REST;
    plotter->left_s = MW_TEXT_ALONE_S;
    if (mw_loop_armed(loop)) {
        (void)mw_loop_drive(loop, (float)MW_SENSE_VOLTAGE_V);
    }
}

static void begin(mw_plotter *plotter, mw_text_task task, float duration_s)
{
    plotter->task = task;
    plotter->left_s = duration_s;
}

/* Up to the amplitude and back to the sense voltage. */
static float swept_v(float left_s)
{
    const float half_s = 0.5f * MW_TEXT_SWEEP_S;
    const float fraction = 1.0f - fabsf(left_s - half_s) / half_s;
    return (float)MW_SENSE_VOLTAGE_V + fraction * (MW_DRIVE_AMPLITUDE_V - (float)MW_SENSE_VOLTAGE_V);
}

/* A number at the beginning of a text, which is moved behind it; not a number if there is none. */
static float number_of(const char **text)
{
    const char *at = *text;
    float value = 0.0f, place = 1.0f;
    bool digits = false, fraction = false;
    while (*at == ' ') {
        at++;
    }
    for (; (*at >= '0' && *at <= '9') || ((*at == '.' || *at == ',') && !fraction); at++) {
        if (*at == '.' || *at == ',') {
            fraction = true;
            continue;
        }
        digits = true;
        value = value * 10.0f + (float)(*at - '0');
        place *= fraction ? 10.0f : 1.0f;
    }
    *text = at;
    return digits ? value / place : NAN;
}

static bool is_end(const char *text)
{
    while (*text == ' ') {
        text++;
    }
    return *text == '\0';
}

/* Follows a drive or a target for the time that its line says. */
static void follow(mw_plotter *plotter, mw_control_loop *loop, bool target, const char *rest_of_line)
{
    const float value = number_of(&rest_of_line);
    const float wanted = target ? value / MW_PLOT_SCALE : value;
    const float lowest = target ? (float)MW_QUANTITY_MIN : 0.0f;
    const float highest = target ? (float)MW_TARGET_HIGHEST : (float)MW_MAXIMUM_VOLTAGE_V;
    const float duration_s = is_end(rest_of_line) ? MW_TEXT_COMMAND_S : number_of(&rest_of_line);
    if (!mw_loop_armed(loop)) {
        say(plotter, not_on_text);
    } else if (!is_end(rest_of_line)) {
        say(plotter, unknown_text);
    } else if (!(wanted >= lowest && wanted <= highest && duration_s > 0.0f && duration_s <= MW_TEXT_LONGEST_S)) {
        say(plotter, range_text);
    } else if (target ? mw_loop_target(loop, wanted) : mw_loop_drive(loop, wanted)) {
        begin(plotter, MW_TEXT_FOLLOW, duration_s);
    }
}

/* If a line begins with a word, returns what follows it; otherwise NULL. */
static const char *after(const char *line, const char *word)
{
    const size_t length = strlen(word);
    const bool same = strncmp(line, word, length) == 0 && (line[length] == '\0' || line[length] == ' ');
    return same ? line + length : NULL;
}

static void switch_on(mw_plotter *plotter, mw_control_loop *loop)
{
    mw_loop_arm(loop);
    loop->expires = false; /* a person sends no heartbeat: the time of each command takes its place */
    plotter->changed = false;
    plotter->settling = true;
    rest(plotter, loop);
    say(plotter, on_text);
}

static void obey(mw_plotter *plotter, mw_control_loop *loop, const char *line)
{
    const char *rest_of_line;
    if ((rest_of_line = after(line, "target")) != NULL) {
        follow(plotter, loop, true, rest_of_line);
    } else if ((rest_of_line = after(line, "drive")) != NULL) {
        follow(plotter, loop, false, rest_of_line);
    } else if (strcmp(line, "stop") == 0 || strcmp(line, "off") == 0) {
        mw_loop_off(loop);
        plotter->task = MW_TEXT_REST;
        say(plotter, off_text);
    } else if (strcmp(line, "on") == 0) {
        switch_on(plotter, loop);
    } else if (strcmp(line, "help") == 0) {
        say(plotter, help_text);
    } else if (strcmp(line, "sense") == 0) {
        rest(plotter, loop);
        say(plotter, mw_loop_armed(loop) ? on_text : off_text);
    } else if (strcmp(line, "sweep") == 0) {
        if (mw_loop_armed(loop)) {
            begin(plotter, MW_TEXT_SWEEP, MW_TEXT_SWEEP_S);
        } else {
            say(plotter, not_on_text);
        }
    } else if (strcmp(line, "plot") != 0) {
        say(plotter, unknown_text);
    }
}

/* The end of a line. In frames, only two words begin to speak text. */
static void finish_line(mw_plotter *plotter, mw_control_loop *loop)
{
    plotter->line[plotter->length] = '\0';
    const bool empty = plotter->length == 0u;
    const bool spoiled = plotter->spoiled;
    plotter->length = 0;
    plotter->spoiled = false;
    if (!plotter->on) {
        plotter->on = !spoiled && (strcmp(plotter->line, "plot") == 0 || strcmp(plotter->line, "help") == 0);
        if (plotter->on) {
            mw_loop_off(loop); /* whoever was in charge is not any more */
            plotter->task = MW_TEXT_REST;
            say(plotter, hello_text);
        }
    }
    if (plotter->on && spoiled) {
        say(plotter, unknown_text);
    } else if (plotter->on && !empty) {
        obey(plotter, loop, plotter->line);
    }
}

bool mw_plotter_byte(mw_plotter *plotter, mw_control_loop *loop, uint8_t byte)
{
    const bool before = plotter->on;
    if (byte == 0u) {
        if (plotter->on) { /* a host: what was typed ends, and its silence counts from now on */
            mw_loop_off(loop);
            loop->expires = true;
        }
        plotter->on = plotter->spoiled = false;
        plotter->length = 0;
    } else if (byte == '\n' || byte == '\r') {
        finish_line(plotter, loop);
    } else if (byte < ' ' || byte > '~' || plotter->length >= MW_TEXT_LINE_BYTES - 1u) {
        plotter->spoiled = true;
    } else {
        plotter->line[plotter->length++] = (char)(byte >= 'A' && byte <= 'Z' ? byte - 'A' + 'a' : byte);
    }
    return plotter->on || (before && byte != 0u);
}

/* What has been commanded goes on or ends. */
static void pass_time(mw_plotter *plotter, mw_control_loop *loop, float passed_s)
{
    if (!mw_loop_armed(loop)) {
        return;
    }
    plotter->left_s -= passed_s;
    if (plotter->left_s > 0.0f) {
        if (plotter->task == MW_TEXT_SWEEP) {
            (void)mw_loop_drive(loop, swept_v(plotter->left_s));
        }
    } else if (plotter->task == MW_TEXT_REST) {
        mw_loop_off(loop);
        say(plotter, alone_text);
    } else {
        rest(plotter, loop);
        say(plotter, over_text);
    }
}

bool mw_plotter_settles(mw_plotter *plotter)
{
    const bool settling = plotter->settling;
    plotter->settling = false;
    return settling;
}

bool mw_plotter_tick(mw_plotter *plotter, mw_control_loop *loop, uint8_t ticks)
{
    if (!plotter->on) {
        return false;
    }
    const float passed_s = (float)ticks * MW_TICK_S;
    pass_time(plotter, loop, passed_s);
    plotter->line_left_s -= passed_s;
    if (send_change(plotter) || send_said(plotter) || plotter->line_left_s > 0.0f) {
        return false;
    }
    plotter->line_left_s += MW_TEXT_LINE_S;
    if (plotter->line_left_s <= 0.0f) {
        plotter->line_left_s = MW_TEXT_LINE_S; /* lines of text have taken their time */
    }
    return true;
}
