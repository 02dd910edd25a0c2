/* Receives LCM messages from the bus in the caller's own thread: one wake-up per message instead of three (LCM hands
 * each from a thread of its own, through a queue and a pipe), and none for messages on other channels, which the kernel
 * filters out. Only messages that fit one datagram, which all of ours do.
 * Wire format of LCM's udpm: "LC02", 32-bit number, channel name with its NUL, message. */
#ifndef SHAKEDOWN_COMMON_UDP_RECEIVER_H
#define SHAKEDOWN_COMMON_UDP_RECEIVER_H

#include <lcm/lcm.h>
#include <stdbool.h>

#include "common/status.h"

struct udp_receiver;

/* Joins the group of a URL udpm://A.B.C.D:PORT[?...]. *receiver becomes NULL, and that is no error, for any other URL.
 * STATUS_BUS if the network does not let it. */
enum status udp_receiver_open(struct udp_receiver **receiver, const char *url) MUST_USE;
void udp_receiver_close(struct udp_receiver *receiver);

/* The handler is called as LCM would. *handle is for udp_receiver_unsubscribe. STATUS_LIMIT for too many channels. */
enum status udp_receiver_subscribe(struct udp_receiver *receiver, const char *channel, lcm_msg_handler_t handler,
                                   void *user, void **handle) MUST_USE;
void udp_receiver_unsubscribe(struct udp_receiver *receiver, void *handle);

/* Handles one message if one comes within timeout_s (0: only what is there). A signal ends the wait early. */
enum status udp_receiver_handle(struct udp_receiver *receiver, double timeout_s, bool *handled) MUST_USE;

#endif
