"""Channels: encryption, and the token that every call carries."""

import collections

import grpc


class _CallDetails(
        collections.namedtuple("_CallDetails", ("method", "timeout", "metadata", "credentials",
                                                "wait_for_ready", "compression")),
        grpc.ClientCallDetails):
    """What an interceptor passes on."""


class _Bearer(grpc.UnaryUnaryClientInterceptor, grpc.UnaryStreamClientInterceptor,
              grpc.StreamUnaryClientInterceptor, grpc.StreamStreamClientInterceptor):
    """Adds the token. Not call credentials: grpc sends those over encrypted channels only, and a
    Unix socket needs no encryption."""

    def __init__(self, token):
        self._metadata = ("authorization", f"Bearer {token}")

    def _intercept(self, call, details, request):
        metadata = [*(details.metadata or ()), self._metadata]
        return call(_CallDetails(details.method, details.timeout, metadata, details.credentials,
                                 details.wait_for_ready, details.compression), request)

    intercept_unary_unary = intercept_unary_stream = _intercept
    intercept_stream_unary = intercept_stream_stream = _intercept


def make(address, token=None, tls_roots=None, tls_cert=None, tls_key=None, keepalive_s=20.0):
    """A channel to `address`; see `pliant.connect`."""
    options = _options(address)
    if keepalive_s > 0:
        # A machine that dies, or a firewall that forgets, closes no connection. The last one: else
        # it would stop asking after two times, while an advance runs in silence.
        options += [("grpc.keepalive_time_ms", int(1000 * keepalive_s)),
                    ("grpc.keepalive_timeout_ms", int(500 * keepalive_s)),
                    ("grpc.http2.max_pings_without_data", 0)]
    if tls_roots is None:
        channel = grpc.insecure_channel(address, options=options)
    else:
        channel = grpc.secure_channel(
            address, grpc.ssl_channel_credentials(tls_roots, tls_key, tls_cert), options=options)
    return channel if token is None else grpc.intercept_channel(channel, _Bearer(token))


def _options(address):
    # A server that is restarted is found again within a second or so, not after minutes.
    options = [("grpc.initial_reconnect_backoff_ms", 100), ("grpc.max_reconnect_backoff_ms", 1000)]
    # A proxy for the world outside must not come between a program and its own machine.
    if address.startswith(("unix:", "localhost:", "127.", "[::1]:")):
        options.append(("grpc.enable_http_proxy", 0))
    return options
