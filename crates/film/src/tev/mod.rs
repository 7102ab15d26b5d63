//! Showing pictures in the viewer tev while they are rendered.
//!
//! Protocol: TCP, little endian, packets of a 32-bit length (itself included), a type byte and
//! a payload (facts from tev's `src/Ipc.cpp`, github.com/Tom94/tev). As pbrt does, pictures are
//! cut into tiles and only tiles that changed are sent.
//!
//! The viewer must never hold up the render: a slow viewer gets what fits into a short time and
//! the rest at the next update; a viewer that goes away is looked for again, quietly.

mod packets;

use std::io::{self, ErrorKind, Write};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

use self::packets::{Shown, TILE};
use crate::Picture;

/// The port that tev listens on unless told otherwise.
pub const TEV_PORT: u16 = 14158;

/// Longest time that one call spends on sending, apart from one last [`WRITE_TIMEOUT`].
const SEND_TIME: Duration = Duration::from_millis(200);

/// Longest wait for the viewer to take more data.
const WRITE_TIMEOUT: Duration = Duration::from_millis(50);

/// Longest wait for a connection.
const CONNECT_TIMEOUT: Duration = Duration::from_millis(250);

/// Least time between attempts to reconnect.
const RETRY_TIME: Duration = Duration::from_secs(1);

/// A connection to a running tev.
#[derive(Debug)]
pub struct TevClient {
    addresses: Vec<SocketAddr>,
    stream: Option<TcpStream>,
    /// The part of a packet that the viewer has not taken yet.
    unsent: Vec<u8>,
    last_attempt: Instant,
    retry_time: Duration,
    images: Vec<Shown>,
}

impl TevClient {
    /// Connects to `host:port` or, on tev's own port, to `host`.
    ///
    /// # Errors
    /// If the name cannot be resolved or nobody listens there; later on, a lost connection is
    /// no error.
    pub fn connect(host_port: &str) -> io::Result<Self> {
        let addresses: Vec<SocketAddr> = match host_port.to_socket_addrs() {
            Ok(found) => found.collect(),
            Err(_) if !host_port.contains(':') => {
                (host_port, TEV_PORT).to_socket_addrs()?.collect()
            }
            Err(e) => return Err(e),
        };
        let stream = open(&addresses)?;
        Ok(TevClient {
            addresses,
            stream: Some(stream),
            unsent: Vec::new(),
            last_attempt: Instant::now(),
            retry_time: RETRY_TIME,
            images: Vec::new(),
        })
    }

    /// False while the viewer is away.
    pub fn is_connected(&self) -> bool {
        self.stream.is_some()
    }

    /// Registers an image of this name with these channels for the viewer; replaces
    /// one of the same name if it differs in size or channels. [`update`](Self::update) does
    /// this by itself.
    pub fn create(&mut self, name: &str, width: u32, height: u32, channels: &[String]) {
        let (width, height) = (width as usize, height as usize);
        if let Some(i) = self.images.iter().position(|image| image.name == name) {
            let image = &self.images[i];
            if (image.width, image.height) == (width, height) && image.channels == channels {
                return;
            }
            self.close(name);
        }
        self.images.push(Shown {
            name: name.into(),
            width,
            height,
            channels: channels.to_vec(),
            is_created: false,
            tiles: vec![None; width.div_ceil(TILE) * height.div_ceil(TILE)],
        });
    }

    /// Sends the tiles of `picture` that differ from what the viewer shows under `name`.
    ///
    /// Returns true if the viewer has been sent all of the picture; false if it is away or too
    /// slow, in which case the next call goes on. A picture whose channels do not fit its size
    /// is not shown.
    pub fn update(&mut self, name: &str, picture: &Picture) -> bool {
        if picture.defect().is_some() {
            return false;
        }
        let names: Vec<String> = picture.channels.iter().map(|c| c.name.clone()).collect();
        self.create(name, picture.width, picture.height, &names);
        self.reconnect();
        let deadline = Instant::now() + SEND_TIME;
        // `create` has just put it there if it was not.
        let Some(i) = self.images.iter().position(|image| image.name == name) else {
            return false;
        };
        if !self.flush(deadline) {
            return false;
        }
        if !self.images[i].is_created {
            self.unsent = self.images[i].create_packet();
            self.images[i].is_created = true;
            if !self.flush(deadline) {
                return false;
            }
        }
        for t in 0..self.images[i].tiles.len() {
            let image = &mut self.images[i];
            let area = image.tile(t);
            let hash = area.hash(picture);
            if image.tiles[t] == Some(hash) {
                continue;
            }
            self.unsent = image.update_packet(&area, picture);
            image.tiles[t] = Some(hash);
            if !self.flush(deadline) {
                return false;
            }
        }
        true
    }

    /// Closes an image in the viewer.
    pub fn close(&mut self, name: &str) {
        let Some(i) = self.images.iter().position(|image| image.name == name) else {
            return;
        };
        let image = self.images.swap_remove(i);
        if image.is_created && self.flush(Instant::now() + SEND_TIME) {
            self.unsent = image.close_packet();
            self.flush(Instant::now() + SEND_TIME);
        }
    }

    /// Sends what is left of the last packet. False if the viewer did not take all of it.
    fn flush(&mut self, deadline: Instant) -> bool {
        let Some(stream) = &mut self.stream else {
            return false;
        };
        let mut sent = 0;
        let is_alive = loop {
            if sent == self.unsent.len() {
                break true;
            }
            match stream.write(&self.unsent[sent..]) {
                Ok(0) => break false,
                Ok(n) => sent += n,
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                    break true;
                }
                Err(_) => break false,
            }
            if Instant::now() > deadline {
                break true;
            }
        };
        self.unsent.drain(..sent);
        if !is_alive {
            self.disconnect();
        }
        is_alive && self.unsent.is_empty()
    }

    /// Forgets what the viewer had.
    fn disconnect(&mut self) {
        self.stream = None;
        self.unsent.clear();
        for image in &mut self.images {
            image.is_created = false;
            image.tiles.fill(None);
        }
    }

    fn reconnect(&mut self) {
        if self.stream.is_none() && self.last_attempt.elapsed() >= self.retry_time {
            self.stream = open(&self.addresses).ok();
            self.last_attempt = Instant::now();
        }
    }
}

fn open(addresses: &[SocketAddr]) -> io::Result<TcpStream> {
    let mut result = Err(io::Error::new(ErrorKind::NotFound, "the host has no address"));
    for address in addresses {
        result = TcpStream::connect_timeout(address, CONNECT_TIMEOUT);
        if result.is_ok() {
            break;
        }
    }
    let stream = result?;
    stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
    Ok(stream)
}

#[cfg(test)]
mod tests {
    use std::io::Read;
    use std::net::TcpListener;
    use std::thread;

    use super::*;

    /// A viewer on a port of its own.
    fn viewer() -> (TcpListener, String) {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        (listener, address)
    }

    fn packet(stream: &mut TcpStream) -> Option<Vec<u8>> {
        let mut length = [0; 4];
        stream.read_exact(&mut length).ok()?;
        let mut body = vec![0; u32::from_le_bytes(length) as usize - 4];
        stream.read_exact(&mut body).unwrap();
        Some(body)
    }

    /// Takes a packet apart.
    struct Parser<'a>(&'a [u8]);

    impl<'a> Parser<'a> {
        fn byte(&mut self) -> u8 {
            let (&first, rest) = self.0.split_first().unwrap();
            self.0 = rest;
            first
        }

        fn four(&mut self) -> [u8; 4] {
            std::array::from_fn(|_| self.byte())
        }

        fn int(&mut self) -> i32 {
            i32::from_le_bytes(self.four())
        }

        fn text(&mut self) -> &'a str {
            let end = self.0.iter().position(|&b| b == 0).unwrap();
            let text = std::str::from_utf8(&self.0[..end]).unwrap();
            self.0 = &self.0[end + 1..];
            text
        }
    }

    /// What a viewer would show of one image after some packets, and the tiles updated.
    #[derive(Default)]
    struct Screen {
        picture: Picture,
        updates: Vec<[i32; 4]>,
        is_closed: bool,
    }

    impl Screen {
        fn take(&mut self, body: &[u8]) {
            let mut p = Parser(body);
            match p.byte() {
                2 => {
                    assert_eq!(p.text(), "test");
                    self.is_closed = true;
                }
                4 => {
                    assert_eq!((p.byte(), p.text()), (1, "test"));
                    self.picture = Picture::new(p.int() as u32, p.int() as u32);
                    let n = self.picture.pixel_count();
                    for _ in 0..p.int() {
                        self.picture.push(p.text(), vec![0.0; n]);
                    }
                }
                5 => {
                    assert_eq!((p.byte(), p.text()), (0, "test"));
                    let names: Vec<&str> = (0..p.int()).map(|_| p.text()).collect();
                    let area: [i32; 4] = std::array::from_fn(|_| p.int());
                    self.updates.push(area);
                    let [x, y, w, h] = area.map(|v| v as usize);
                    let stride = self.picture.width as usize;
                    for name in names {
                        let channels = &mut self.picture.channels;
                        let channel = channels.iter_mut().find(|c| c.name == name).unwrap();
                        for i in 0..w * h {
                            let at = (y + i / w) * stride + x + i % w;
                            channel.data[at] = f32::from_le_bytes(p.four());
                        }
                    }
                }
                kind => panic!("packet of type {kind}"),
            }
            assert!(p.0.is_empty(), "bytes left over");
        }
    }

    fn gradient(width: u32, height: u32) -> Picture {
        let mut p = Picture::new(width, height);
        for (c, name) in ["R", "G", "B", "Albedo.R"].into_iter().enumerate() {
            p.push(name, (0..width * height).map(|i| (i * 4) as f32 + c as f32).collect());
        }
        p
    }

    #[test]
    fn changed_tiles_arrive_and_only_they() {
        let (listener, address) = viewer();
        let server = thread::spawn(move || {
            let (mut stream, _) = listener.accept().unwrap();
            let mut screen = Screen::default();
            while let Some(body) = packet(&mut stream) {
                screen.take(&body);
            }
            screen
        });
        let mut client = TevClient::connect(&address).unwrap();
        let mut picture = gradient(200, 130);
        let show = |client: &mut TevClient, picture: &Picture| {
            while !client.update("test", picture) {
                assert!(client.is_connected());
            }
        };
        show(&mut client, &picture);
        show(&mut client, &picture);
        picture.channels[2].data[130] = -1.0;
        show(&mut client, &picture);
        client.close("test");
        client.close("never opened");
        drop(client);
        let screen = server.join().unwrap();
        assert_eq!(screen.picture, picture);
        let all = [[0, 0, 128, 128], [128, 0, 72, 128], [0, 128, 128, 2], [128, 128, 72, 2]];
        assert_eq!(screen.updates[..4], all);
        assert_eq!(screen.updates[4..], [[128, 0, 72, 128]]);
        assert!(screen.is_closed);
    }

    #[test]
    fn a_slow_viewer_gets_the_picture_in_the_end() {
        let (listener, address) = viewer();
        let mut client = TevClient::connect(&address).unwrap();
        let (mut stream, _) = listener.accept().unwrap();
        // Far more than the buffers of the two sockets: cannot be sent while nobody reads.
        let picture = gradient(1600, 1600);
        assert!(!client.update("test", &picture));
        assert!(client.is_connected());
        let server = thread::spawn(move || {
            let mut screen = Screen::default();
            while let Some(body) = packet(&mut stream) {
                screen.take(&body);
            }
            screen
        });
        while !client.update("test", &picture) {
            assert!(client.is_connected());
        }
        drop(client);
        assert_eq!(server.join().unwrap().picture, picture);
    }

    #[test]
    fn a_lost_viewer_is_found_again() {
        let (listener, address) = viewer();
        let mut client = TevClient::connect(&address).unwrap();
        client.retry_time = Duration::ZERO;
        let mut picture = gradient(20, 10);
        drop(listener.accept().unwrap());
        // Until the system notices that the other end is closed.
        while client.is_connected() {
            picture.channels[0].data[0] += 1.0;
            client.update("test", &picture);
        }
        assert!(client.update("test", &picture));
        drop(listener.accept().map(|(mut stream, _)| {
            let mut screen = Screen::default();
            (0..2).for_each(|_| screen.take(&packet(&mut stream).unwrap()));
            assert_eq!(screen.picture, picture);
        }));
        drop(listener);
        assert!(TevClient::connect(&address).is_err());
    }
}
