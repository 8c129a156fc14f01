/* An ATmega328P in simavr between two sockets: its UART0 and, for its converter and PWM, the bench.
 *
 *     simavr_board FIRMWARE HOST_PORT WIRE_PORT
 *
 * FIRMWARE is an ELF file, or the Intel HEX file that is flashed. A HEX file of a boot loader alone, which begins in the
 * boot section, is what a reset starts, as the fuse BOOTRST has it; the rest of the flash is then empty.
 *
 * The bench keeps time: each conversion packet (see firmware/boards/mps2-an386/board.c) carries the voltages at A0 and
 * A1 and lets one tick of processor cycles pass; the answer is what the PWM on D9 puts out. Every 100 ticks a line on
 * standard error says how many cycles of a tick the processor was awake.
 */
#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include <simavr/avr_adc.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>
#include <simavr/sim_hex.h>
#include <simavr/sim_regbit.h>

#define CLOCK_HZ 16000000u
#define TICK_CYCLES (CLOCK_HZ / 100u)
#define SUPPLY_MV 5000u
#define NOISE_MV 3.0 /* rms at the converter's input, as circuit.toml says */
#define CONVERSION 0xa5
#define BUTTON 0xb7 /* and a byte: 1 is down */
#define KNOB 0xb8   /* and a byte: 255 is the far end */
#define RESET 0xb9  /* and any byte: the reset pin is pulled low and let go */
#define OUTPUT 0x3c
#define OUTPUT_AT_START 0x3d
/* Data memory addresses of the ATmega328P */
#define TCCR1A_AT 0x80
#define COM1A1_BIT 0x80
#define OCR1A_AT 0x88
#define REPORT_TICKS 100u
#define BOOT_SECTION 0x7000u /* the largest that the fuses allow begins here */

static avr_t *avr;
static avr_irq_t *converter, *serial;
static int host, wire;
static double pin_mv[3];
static int may_receive = 1;
static unsigned char answered;
static avr_cycle_count_t tick_end;

static int connected(const char *port)
{
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_port = htons((unsigned short)atoi(port))};
    const int made = socket(AF_INET, SOCK_STREAM, 0), yes = 1;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (made < 0 || connect(made, (struct sockaddr *)&address, sizeof address) != 0) {
        perror("simavr_board: connect");
        exit(1);
    }
    setsockopt(made, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    return made;
}

/* About normal, by the sum of twelve: a generator of its own, the same for every run. */
static double noise(void)
{
    static unsigned state = 1;
    double sum = -6.0;
    for (int i = 0; i < 12; i++) {
        state = state * 1664525u + 1013904223u;
        sum += (double)(state >> 8) / 16777216.0;
    }
    return sum;
}

static void conversion_starts(struct avr_irq_t *irq, uint32_t value, void *parameter)
{
    (void)irq;
    (void)parameter;
    union {
        avr_adc_mux_t mux;
        uint32_t value;
    } asked = {.value = value};
    const unsigned channel = asked.mux.src;
    double mv = channel < 3 ? pin_mv[channel] + NOISE_MV * noise() : 0.0;
    mv = mv < 0.0 ? 0.0 : mv;
    avr_raise_irq(converter + ADC_IRQ_ADC0 + channel, (uint32_t)(mv + 0.5));
}

static void byte_to_host(struct avr_irq_t *irq, uint32_t value, void *parameter)
{
    (void)irq;
    (void)parameter;
    const unsigned char byte = (unsigned char)value;
    if (send(host, &byte, 1, MSG_DONTWAIT | MSG_NOSIGNAL) < 0 && errno != EAGAIN)
        exit(0);
}

static void receiver_has_room(struct avr_irq_t *irq, uint32_t value, void *parameter)
{
    (void)irq;
    (void)value;
    may_receive = *(int *)parameter;
}

/* simavr would really sleep; here the bench keeps time. */
static void sleep_at_once(avr_t *processor, avr_cycle_count_t cycles)
{
    (void)processor;
    (void)cycles;
}

/* A button between D2 and ground: its pull-up holds the pin while it is up. */
static void set_button(int down)
{
    avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('D'), 2), down ? 0 : 1);
}

/* Pulls the reset pin: an external reset, which is what a boot loader waits for a host after. */
static void press_reset(void)
{
    avr_reset(avr);
    avr_regbit_set(avr, avr->reset_flags.extrf);
    set_button(0);
    may_receive = 1;
    tick_end = 0;
}

static void put_output(unsigned char kind)
{
    const int driven = avr->data[TCCR1A_AT] & COM1A1_BIT;
    const unsigned char low = driven ? avr->data[OCR1A_AT] : 0, high = driven ? avr->data[OCR1A_AT + 1] : 0;
    unsigned char packet[5] = {kind, low, high, answered, 0};
    packet[4] = (unsigned char)(packet[0] ^ packet[1] ^ packet[2] ^ packet[3]);
    if (send(wire, packet, sizeof packet, MSG_NOSIGNAL) < 0)
        exit(0);
}

static void take_from_host(void)
{
    unsigned char byte;
    while (may_receive && recv(host, &byte, 1, MSG_DONTWAIT) == 1) {
        avr_raise_irq(serial + UART_IRQ_INPUT, byte);
        if (!may_receive)
            return;
    }
}

/* Lets one tick of cycles pass and returns how many of them the processor was awake. */
static avr_cycle_count_t run_tick(void)
{
    avr_cycle_count_t awake = 0, polled = avr->cycle;
    if (tick_end == 0)
        tick_end = avr->cycle;
    tick_end += TICK_CYCLES;
    while (avr->cycle < tick_end) {
        const avr_cycle_count_t before = avr->cycle;
        const int runs = avr->state == cpu_Running;
        const avr_flashaddr_t from = avr->pc;
        const int state = avr_run(avr);
        if (state == cpu_Done || state == cpu_Crashed) {
            fprintf(stderr, "simavr_board: the processor has crashed\n");
            exit(1);
        }
        if (avr->cycle < before) { /* the watchdog has reset the processor, which counts from 0 again */
            tick_end -= before;
            polled = 0;
            may_receive = 1;
            continue;
        }
        if (runs)
            awake += avr->cycle - before;
        if (avr->pc == 0 && from != 0)
            put_output(OUTPUT_AT_START);
        if (avr->cycle - polled > CLOCK_HZ / 25000u) { /* a byte at 250 kBd takes 640 cycles */
            polled = avr->cycle;
            take_from_host();
        }
    }
    return awake;
}

static void report(avr_cycle_count_t awake)
{
    static unsigned ticks;
    static avr_cycle_count_t sum, most;
    sum += awake;
    most = awake > most ? awake : most;
    if (++ticks % REPORT_TICKS == 0) {
        fprintf(stderr, "cycles of a tick awake: mean %lu, most %lu of %u\n", (unsigned long)(sum / REPORT_TICKS),
                (unsigned long)most, TICK_CYCLES);
        sum = most = 0;
    }
}

static int take_from_bench(unsigned char *bytes, size_t count)
{
    return recv(wire, bytes, count, MSG_WAITALL) == (ssize_t)count;
}

/* Reads what the bench says until a conversion is whole. */
static int next_conversion(void)
{
    unsigned char packet[7];
    do {
        if (!take_from_bench(packet, 1))
            return 0;
        const int is_input = packet[0] == BUTTON || packet[0] == KNOB || packet[0] == RESET;
        if (is_input && take_from_bench(packet + 1, 1)) {
            if (packet[0] == BUTTON)
                set_button(packet[1]);
            else if (packet[0] == RESET)
                press_reset();
            else
                pin_mv[2] = packet[1] / 255.0 * SUPPLY_MV;
        }
    } while (packet[0] != CONVERSION);
    if (!take_from_bench(packet + 1, sizeof packet - 1))
        return 0;
    pin_mv[0] = (packet[1] + 256.0 * packet[2]) / 65535.0 * SUPPLY_MV;
    pin_mv[1] = (packet[3] + 256.0 * packet[4]) / 65535.0 * SUPPLY_MV;
    answered = packet[5];
    return 1;
}

/* Fills the flash from an ELF file, or from the very bytes of a HEX file. */
static int load(const char *file)
{
    static elf_firmware_t firmware;
    const char *end = strrchr(file, '.');
    if (end != NULL && strcmp(end, ".hex") == 0) {
        ihex_chunk_p parts = NULL;
        const int count = read_ihex_chunks(file, &parts);
        for (int i = 0; i < count; i++)
            avr_loadcode(avr, parts[i].data, parts[i].size, parts[i].baseaddr);
        if (count > 0 && parts[0].baseaddr >= BOOT_SECTION)
            avr->reset_pc = parts[0].baseaddr;
        avr->codeend = avr->flashend;
        return count > 0;
    }
    if (elf_read_firmware(file, &firmware) != 0)
        return 0;
    avr_load_firmware(avr, &firmware);
    return 1;
}

static void build_processor(const char *file)
{
    static int yes = 1, no = 0;
    uint32_t flags = 0;
    if (!(avr = avr_make_mcu_by_name("atmega328p")))
        exit(1);
    avr_init(avr);
    if (!load(file))
        exit(1);
    avr->frequency = CLOCK_HZ;
    avr->vcc = avr->avcc = avr->aref = SUPPLY_MV;
    avr->sleep = sleep_at_once;
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags); /* no echo, no waiting while it polls */
    converter = avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, 0);
    serial = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), 0);
    avr_irq_register_notify(converter + ADC_IRQ_OUT_TRIGGER, conversion_starts, NULL);
    avr_irq_register_notify(serial + UART_IRQ_OUTPUT, byte_to_host, NULL);
    avr_irq_register_notify(serial + UART_IRQ_OUT_XON, receiver_has_room, &yes);
    avr_irq_register_notify(serial + UART_IRQ_OUT_XOFF, receiver_has_room, &no);
    press_reset();
}

int main(int count, char **arguments)
{
    if (count != 4) {
        fprintf(stderr, "simavr_board FIRMWARE HOST_PORT WIRE_PORT\n");
        return 2;
    }
    build_processor(arguments[1]);
    host = connected(arguments[2]);
    wire = connected(arguments[3]);
    put_output(OUTPUT_AT_START);
    while (next_conversion()) {
        report(run_tick());
        put_output(OUTPUT);
    }
    return 0;
}
